#pragma once

#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// The links without those across sharp lattice edges: straight rows of linels where two flat
/// strips meet at a right angle, strips at least 3 surfels wide over 2 linels, or 2 surfels wide
/// over 4.
///
/// Along a digital plane one of the two runs that meet at a step is 1 surfel long, and on a round
/// digital surface such a row is never that long (tried for balls of radius 3 to 24 at random
/// places), so these edges are meant: windows of estimators that stop there keep cubes, steps and
/// pillars exact.
/// @return  symmetric, a subset of `links`
/// @errors  cancelled
/// @cost    O(surfels), 4 bytes a surfel beside the result
/// @source  ours
Result<SurfelLinks> cutSharpEdges(const DigitalSurface& surface, const SurfelLinks& links,
                                  const RunContext& run);

}  // namespace rivage::core
