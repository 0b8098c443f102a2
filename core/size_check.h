#pragma once

#include <cstdint>

#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// Peak memory of a conversion to a mesh, bytes, from its counts: the surface, the energy, the
/// solver with the most vectors, the relief, the mesh and the artifact. Measured peaks are 450
/// (noise) to 1060 bytes a surfel (voxel art).
[[nodiscard]] std::uint64_t predictMemory(const VoxelGrid& grid, const SurfaceSize& size,
                                          const EmbossOptions& emboss = {});

/// Refuses a conversion that would be above a limit, before anything is made.
/// @param options  none: nothing is written
/// @errors  memoryBudget; those of `checkVoxelOutput`; cancelled
/// @cost    that of `countSurface`
Result<SurfaceSize> checkSize(const VoxelGrid& grid, const ConversionOptions* options,
                              const RunContext& run);

}  // namespace rivage::core
