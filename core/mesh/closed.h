#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/voxel_grid.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// What is left open of the boundary of a label.
enum class Closure : std::uint8_t {
    closed,        ///< every edge has an even number of its faces
    openAtBorder,  ///< all edges with an odd number lie on the border of an open domain
    open,
};

/// Whether the boundary of each label is closed, by pointels and not by their places: what was
/// split must be closed by itself.
/// @return  one entry a label, label 1 first. Means nothing once `run` asked to stop.
/// @cost    O(surfels) time, 36 bytes a surfel for a while
[[nodiscard]] std::vector<Closure> labelClosures(const VoxelGrid& grid,
                                                 const DigitalSurface& surface,
                                                 const RunContext& run = {});

}  // namespace rivage::core
