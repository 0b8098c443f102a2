#pragma once

#include <cstdint>
#include <string>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/scene.h"
#include "core/grid/voxel_grid.h"

namespace rivage::core {

/// A scene that a .vox file can hold, and what had to give for it.
struct VoxelScene {
    Scene scene;
    std::uint64_t colors = 0;    ///< palette entries in use
    bool colorsReduced = false;  ///< there were more than 255
    double errorMax = 0;         ///< of a colour, OKLab distance
    double errorMean = 0;        ///< over all voxels
};

/// Makes a scene of a grid: materials become at most 255 palette entries (`reducePalette`), and a
/// grid longer than 256 is cut into models of 256^3, placed edge to edge; empty ones are dropped.
/// What would lie outside -1000..999, the world of the editor, is moved to its middle.
/// @param grid  taken apart, so that its voxels are not held twice
/// @errors tooManyLabels; cancelled
/// @cost   O(voxels); a grid that is cut needs its bricks twice for a while
Result<VoxelScene> voxelScene(VoxelGrid&& grid, const RunContext& run);

}  // namespace rivage::core
