#pragma once

#include "core/base/options.h"
#include "core/base/report.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/voxelize/label_columns.h"

namespace rivage::core {

/// The samples that decide on voxels at a scale below 1: a cube of them for each, at least four
/// along each axis and at least two for each voxel of the input.
/// @param size   voxels of the result
[[nodiscard]] SampleLattice samplesFor(const Vec3i& size, const Scale& scale);

/// Coarser voxels of a regularized model. Each takes the label that most of its samples have, on a
/// tie a solid one. Parts that are thinner than that, but fill at least a third of their voxels,
/// come back where otherwise a whole part of a label would be lost, or the end of one. The colour
/// is the palette entry that is seen most from outside, near ones counted together.
/// @param columns  at the samples of `samplesFor`
/// @param size     voxels of the result
/// @param report   gets `samplesEach` and `rescued`
/// @return  materials and labels are those of the input, by id; the same for any number of threads
/// @errors  memoryBudget; cancelled
/// @cost    O(samples of solid labels)
/// @source  METHOD.md 5; the vote is ours
Result<VoxelGrid> coarsen(const VoxelGrid& grid, const NearestSurfel& nearest,
                          const LabelColumns& columns, const Vec3i& size, const RunContext& run,
                          VoxelReport& report);

}  // namespace rivage::core
