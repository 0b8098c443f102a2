#pragma once

#include <array>

#include "core/surface/digital_surface.h"

namespace rivage::core {

/// Per surfel and edge k (from corner k to corner k + 1): the surfel of the same interface on the
/// other side, kNone at a junction linel or where four sheets meet and none is paired.
using SurfelLinks = IdVector<SurfelId, std::array<SurfelId, 4>>;

/// Links the surfels of each interface through their edges.
///
/// Where four surfels of one interface meet at a linel, the two that share a voxel of the label
/// `Interface::through` are linked, so that the two sides of a diagonal sheet do not mix.
/// @return   symmetric: g is a link of s exactly if s is one of g
/// @errors   cancelled
/// @cost     O(surfels), 16 bytes a surfel
/// @source   ours
Result<SurfelLinks> linkSurfels(const DigitalSurface& surface, const RunContext& run);

}  // namespace rivage::core
