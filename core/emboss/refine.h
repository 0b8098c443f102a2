#pragma once

#include <array>
#include <cstdint>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/energy/energy.h"
#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// A digital surface with every surfel cut into detail * detail, where its pointels have moved to.
///
/// It is a digital surface on a lattice that is as many times finer: a pointel for each pointel,
/// detail - 1 for each linel, (detail - 1)^2 for each surfel. What shares a linel shares its
/// pointels, so patches of all labels coincide and stay closed.
struct RefinedSurface {
    DigitalSurface surface;
    SurfelLinks links;
    PointelVectors rest;  ///< bilinear between the moved corners, voxel units
    int detail = 1;

    /// The surfel that a refined one is a piece of.
    [[nodiscard]] SurfelId parent(SurfelId s) const {
        return SurfelId{index(s) / static_cast<std::uint32_t>(detail * detail)};
    }
};

/// Cuts all surfels. Piece (i, j) of surfel s is number s detail^2 + j detail + i, with i along its
/// first edge; pointels are sorted by their place on the finer lattice. `firstSurfel` and
/// `surfelAxes` are empty, as after `splitUmbrellas`.
/// @param surface    split or not
/// @param positions  of its pointels, voxel units
/// @param detail     at least 1
/// @errors  tooLarge if there would be 2^32 - 1 pieces or pointels; cancelled
/// @cost    O(pieces) time, about 180 bytes a piece
/// @source  ours
Result<RefinedSurface> refineSurface(const DigitalSurface& surface, const SurfelLinks& links,
                                     const PointelVectors& positions, int detail,
                                     const RunContext& run);

}  // namespace rivage::core
