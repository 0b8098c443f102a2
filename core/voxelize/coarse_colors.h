#pragma once

#include <vector>

#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/voxelize/label_columns.h"
#include "core/voxelize/resample.h"

namespace rivage::core {

/// By label, its first material: stands for the label until `colorVoxels`.
[[nodiscard]] std::vector<MaterialId> firstMaterials(const VoxelGrid& grid);

/// Gives each voxel of a coarser grid the material that most of its samples have: those on voxels
/// of the input that show a face of the label, if there are any. Materials whose colours are close
/// (OKLab distance 0.05) count for one another; on a tie the one with more samples of its own, then
/// the one with the smaller id.
/// @param each    samples along each side of a voxel of `coarse`
/// @param coarse  has its labels; gets its materials
/// @return  false if `run` asked to stop
/// @cost    O(samples in voxels of `coarse`)
bool colorVoxels(const VoxelGrid& grid, const SampleMaterials& materials,
                 const LabelColumns& columns, int each, VoxelGrid& coarse, const RunContext& run);

}  // namespace rivage::core
