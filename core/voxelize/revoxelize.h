#pragma once

#include "core/base/options.h"
#include "core/base/report.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// Size of the result of `revoxelize`, voxels.
[[nodiscard]] Vec3i scaledSize(const Vec3i& grid, const Scale& scale);

/// The regularized model as voxels at another resolution: point samples at a scale of 1 and more
/// (`resample`), majorities of many samples below (`coarsen`).
/// @param positions  of the pointels, units of the shortest side of a voxel
/// @param report     gets dims, scale, folded samples and topology
/// @return  materials and labels are those of the input, by id; stands at the input's origin times
///          the scale, rounded down
/// @errors  tooLarge above `maxVoxels`; memoryBudget; internal; cancelled
Result<VoxelGrid> revoxelize(const VoxelGrid& grid, const DigitalSurface& surface,
                             const IdVector<PointelId, Vec3d>& positions, const Scale& scale,
                             const RunContext& run, VoxelReport& report);

}  // namespace rivage::core
