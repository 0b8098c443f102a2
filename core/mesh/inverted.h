#pragma once

#include <cstddef>
#include <vector>

#include "core/base/ids.h"
#include "core/base/run_context.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// The faces that are folded over or collapsed: two of their corner normals point more than a
/// right angle apart, their area is below 0.02 voxel^2, or a position is not finite.
/// @return  ascending
/// @cost    O(surfels)
/// @source  METHOD.md 7.3
[[nodiscard]] std::vector<SurfelId> invertedFaces(const DigitalSurface& surface,
                                                  const IdVector<PointelId, Vec3d>& positions);

/// Draws the corners of inverted faces back towards their lattice places, step by step, until no
/// face is inverted. A vertex only ever moves on the segment to its own pointel, so every box or
/// ball around the pointel keeps it.
/// @return  the number of faces that were inverted; the same bits for any thread count. If `run`
///          asks to stop, some faces may still be inverted.
/// @cost    O(surfels) a round, rarely more than 20 rounds
/// @source  METHOD.md 7.3; the lattice places themselves are valid, so it ends
std::size_t untangle(const DigitalSurface& surface, IdVector<PointelId, Vec3d>& positions,
                     const RunContext& run);

}  // namespace rivage::core
