#pragma once

#include <vector>

#include "core/base/report.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"

namespace rivage::core {

/// Components, tunnels and cavities of each label: its voxels hang together by faces, edges and
/// corners, what is around them by faces. With an open border the outside is not of the label.
/// @return  label 1 first
/// @errors  cancelled
/// @cost    O(voxels) time, and for each label O(rows of its bounding box); 12 bytes a run of
///          voxels along x
/// @source  Euler's formula on the cubes of a label: components - tunnels + cavities = V - E + F - C
Result<std::vector<VoxelReport::Topology>> labelTopology(const VoxelGrid& grid,
                                                         const RunContext& run);

}  // namespace rivage::core
