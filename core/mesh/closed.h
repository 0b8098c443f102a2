#pragma once

#include <vector>

#include "core/grid/voxel_grid.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// Whether the boundary of each label is closed: every linel has an even number of its surfels.
/// @return  one entry a label, label 1 first
/// @cost    O(surfels)
[[nodiscard]] std::vector<bool> closedLabels(const VoxelGrid& grid, const DigitalSurface& surface);

}  // namespace rivage::core
