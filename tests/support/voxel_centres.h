#pragma once

#include "core/energy/energy.h"
#include "core/grid/voxel_grid.h"
#include "core/surface/digital_surface.h"

namespace rivage::test {

using namespace rivage::core;

/// Number of voxel centres that the moved surface puts on the side of another label. Exact up to
/// rounding: every label's winding number is summed over the faces that a ray along z crosses.
/// Counts the voxels of the grid and one layer around it.
std::size_t countWrongCentres(const VoxelGrid& grid, const DigitalSurface& surface,
                              const PointelVectors& positions);

}  // namespace rivage::test
