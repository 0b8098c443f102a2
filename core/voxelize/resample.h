#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/voxelize/label_columns.h"

namespace rivage::core {

/// Looks up the material of a sample: that of the input voxel which holds it where that has the
/// label of the sample, so that what lies inside keeps its detail; else that of the nearest face
/// of the label. So every material is one of the input.
class SampleMaterials {
public:
    /// @param grid, nearest  must outlive it
    SampleMaterials(const VoxelGrid& grid, const NearestSurfel& nearest);

    /// @param held  material of the input voxel that holds the sample
    [[nodiscard]] MaterialId of(MaterialId held, Label label, const Vec3d& at) const {
        return grid_.materials[held].label == label ? held : nearestOf(label, at);
    }
    /// The material of the nearest face of a label.
    [[nodiscard]] MaterialId nearestOf(Label label, const Vec3d& at) const;

private:
    const VoxelGrid& grid_;
    const NearestSurfel& nearest_;
};

/// The voxels of a regularized model at the samples of a lattice.
/// @param grid     the input
/// @param columns  of `scanLabels`, at least one sample a voxel
/// @return  materials and labels are those of the input, by id; the same for any number of threads
/// @errors  tooLarge above `maxVoxels`; memoryBudget; cancelled
/// @cost    O(samples in bricks that are not empty); 2 bytes each
/// @source  METHOD.md 5
Result<VoxelGrid> resample(const VoxelGrid& grid, const NearestSurfel& nearest,
                           const LabelColumns& columns, const RunContext& run);

}  // namespace rivage::core
