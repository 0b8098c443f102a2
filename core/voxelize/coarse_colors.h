#pragma once

#include <vector>

#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/voxelize/label_columns.h"
#include "core/voxelize/resample.h"

namespace rivage::core {

/// By label, its first material: stands for the label until `colorVoxels`.
[[nodiscard]] std::vector<MaterialId> firstMaterials(const VoxelGrid& grid);

/// Voxels of a coarser grid with their materials: that which most of the samples have that are seen
/// through the faces of the voxel against other labels, looking straight on; of all its samples
/// where it has no such face. Materials whose colours are close (OKLab distance 0.05) count for one
/// another; on a tie the one with more samples of its own, then the one with the smaller id.
/// @param each    samples along each side of a voxel of `coarse`
/// @param coarse  has its labels
/// @return  the voxels of `coarse`; means nothing once `run` asked to stop
/// @cost    O(samples in voxels of `coarse`)
/// @source  ours: a wall behind a roof does not show through it
[[nodiscard]] BrickGrid colorVoxels(const VoxelGrid& grid, const SampleMaterials& materials,
                                    const LabelColumns& columns, int each, const VoxelGrid& coarse,
                                    const RunContext& run);

}  // namespace rivage::core
