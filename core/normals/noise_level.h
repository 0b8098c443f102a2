#pragma once

#include <vector>

#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// Whether each surfel stands out: a surfel that faces the opposite way lies two links away. So do
/// the surfels around flipped voxels, and those of one-voxel details.
/// @cost O(surfels)
IdVector<SurfelId, std::uint8_t> findStandouts(const DigitalSurface& surface,
                                               const SurfelLinks& links, const RunContext& run);

/// How noisy the labels are, per interface: 0 clean, 1 noisy, between them a transition.
///
/// Clean shapes and drawn art always have regions without standouts; label noise has them
/// everywhere. So the measure is their density in discs of radius 5 that the cleanest quarter of
/// the surfels stays below: 0 to 0.03 on clean shapes and on scenes of voxel art, about 0.1 where
/// 5 % of the boundary voxels are flipped, 0.2 and more where 10 % are. An interface of less than
/// 1000 surfels is judged by those of the whole grid; a grid of less counts as clean.
/// @param density  of the standouts in the disc around each surfel, 0 to 1
/// @cost    O(surfels)
/// @source  ours
std::vector<double> noiseLevels(const DigitalSurface& surface,
                                const IdVector<SurfelId, float>& density, const RunContext& run);

}  // namespace rivage::core
