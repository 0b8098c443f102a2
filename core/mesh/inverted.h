#pragma once

#include <cstddef>
#include <vector>

#include "core/base/ids.h"
#include "core/base/run_context.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// The faces that are folded over or collapsed: two of their corner normals point more than a
/// right angle apart, their area is below 2 % of that on the lattice, or a position is not finite.
/// @return  ascending; some are missing once `run` asked to stop
/// @cost    O(surfels)
/// @source  METHOD.md 7.3
[[nodiscard]] std::vector<SurfelId> invertedFaces(const DigitalSurface& surface,
                                                  const IdVector<PointelId, Vec3d>& positions,
                                                  const RunContext& run = {});

/// What `untangle` found before it moved anything.
struct Tangles {
    std::size_t inverted = 0;  ///< faces
    std::size_t crossing = 0;  ///< pairs of faces, see `crossingFaces`
};

/// Draws the corners of inverted faces back towards their lattice places, step by step, until no
/// face is inverted; and, where faces around different copies of a split pointel cross, these
/// copies, and once they are at home all corners of the two faces. Then they are let go again, one
/// after the other, as far as nothing tangles. A vertex only ever moves on the segment to its own
/// pointel, so every box or ball around the pointel keeps it.
/// @param home  where positions are drawn back to, in place of the lattice; tangles that are there
///              already stay
/// @return  the same for any thread count. If `run` asks to stop, some tangles may be left.
/// @cost    O(surfels) a round, rarely more than 20 rounds; then O(vertices drawn back)
/// @source  METHOD.md 7.3; on the lattice itself no face is inverted or crosses, so it ends
Tangles untangle(const DigitalSurface& surface, IdVector<PointelId, Vec3d>& positions,
                 const RunContext& run, const IdVector<PointelId, Vec3d>* home = nullptr);

}  // namespace rivage::core
