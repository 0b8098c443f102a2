#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/options.h"
#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// One unit vector per surfel, from the inner to the outer label.
using NormalField = IdVector<SurfelId, Vec3d>;

/// What `NormalMethod::automatic` found on one interface.
struct InterfaceNormals {
    double noise = 0;   ///< share of the estimate for noisy labels, 0 to 1
    double sharp = 0;   ///< mean share of the estimate for creases, 0 to 1
    double radius = 0;  ///< mean radius of the windows on smooth parts, voxels
};

struct NormalEstimate {
    NormalField normals;
    std::vector<InterfaceNormals> interfaces;  ///< one each; only `NormalMethod::automatic`
    /// Linels where the normals jump; only `NormalMethod::piecewiseSmooth`.
    std::optional<std::uint64_t> featureLinels;
};

/// Estimates the normals of all interfaces, each from its own surfels.
/// @param links    of the surface
/// @param options  estimator and its radius, in units of the shortest side of a voxel
/// @errors  cancelled
/// @cost    convolved: O(surfels * radius^2); integral invariants: O(surfels * radius^3); see the
///          headers of the others
/// @source  convolved: METHOD.md 3.1; the others name theirs
Result<NormalEstimate> estimateNormalsAndChoices(const VoxelGrid& grid,
                                                 const DigitalSurface& surface,
                                                 const SurfelLinks& links,
                                                 const NormalOptions& options,
                                                 const RunContext& run);

/// As above, the normals alone.
Result<NormalField> estimateNormals(const VoxelGrid& grid, const DigitalSurface& surface,
                                    const SurfelLinks& links, const NormalOptions& options,
                                    const RunContext& run);

}  // namespace rivage::core
