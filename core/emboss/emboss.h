#pragma once

#include "core/base/options.h"
#include "core/base/report.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/emboss/refine.h"
#include "core/grid/voxel_grid.h"

namespace rivage::core {

/// A surface with relief.
struct Embossed {
    RefinedSurface refined;
    PointelVectors positions;  ///< of its pointels, voxel units
    EmbossReport report;       ///< all but what is looked for in the positions
};

/// What `emboss` works on.
struct EmbossInput {
    const VoxelGrid& grid;
    const DigitalSurface& surface;
    const SurfelLinks& links;
    const NormalField& normals;       ///< the estimate; it chooses the frames
    const PointelVectors& positions;  ///< where the pointels have moved to
};

/// Cuts the surfels and gives the faces of some materials the relief of height tiles.
///
/// `displace`: each pointel moves by the mean height along the mean normal, mitred at creases.
/// `normals`: each piece gets the normal of its tile, n' = normalize(n - h_u t_u - h_v t_v).
/// Then the energy is minimized again, counted from the surface that is there (`RestShape`), with
/// what `displace` gives as targets of the data term. Without these, heights that do not fit
/// together, where tiles meet at corners, would lift or sink whole walls.
///
/// No pointel moves further than the depth of the tiles around it, none without a tile around it
/// moves at all, and each stays within the displacement limit of its own place on its voxel face:
/// so what a limit below 0.5 promises of voxel centres holds for the pieces.
/// @param options  with rules; `method.energy` and `method.solve` as for the surface itself
/// @errors  invalidOption if a rule names nothing in the grid; tooLarge; cancelled
/// @cost    that of the energy and the solver on detail^2 as many surfels; `displace`: O(pieces)
/// @source  METHOD.md 5; measuring from the rest shape, the frames and the rooms are ours
Result<Embossed> emboss(const EmbossInput& input, const ConversionOptions& options,
                        const RunContext& run);

}  // namespace rivage::core
