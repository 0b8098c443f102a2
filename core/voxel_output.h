#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/base/options.h"
#include "core/base/report.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// What a conversion takes without its output.
struct ConversionSize {
    std::uint64_t surfels = 0;
    std::uint64_t memory = 0;  ///< predicted bytes
};

/// Refuses a voxel output that would be above a limit, before anything is made of it.
/// @errors  invalidOption for a .vox of voxels that are no cubes; tooLarge, outputTooLarge,
///          memoryBudget, each for /options/scale; cancelled
/// @cost    O(stored voxels); a bit for each brick of the result
Result<void> checkVoxelOutput(const VoxelGrid& grid, const ConversionSize& conversion,
                              const OutputOptions& output, const RunContext& run);

/// The last stages of a conversion to voxels: samples the regularized model and writes the file.
/// @param report  gets `voxels` and warnings
/// @errors  tooLarge, tooManyLabels, outputTooLarge, memoryBudget; cancelled
Result<std::vector<std::byte>> writeVoxels(const VoxelGrid& grid, const DigitalSurface& surface,
                                           const IdVector<PointelId, Vec3d>& positions,
                                           const OutputOptions& output, const RunContext& run,
                                           ConversionReport& report);

}  // namespace rivage::core
