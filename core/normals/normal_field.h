#pragma once

#include "core/base/options.h"
#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// One unit vector per surfel, from the inner to the outer label.
using NormalField = IdVector<SurfelId, Vec3d>;

/// Estimates the normals of all interfaces, each from its own surfels.
/// @param links    of the surface
/// @param options  estimator and its radius in voxels
/// @errors  cancelled
/// @cost    convolved: O(surfels * radius^2); integral invariants: O(surfels * radius^3)
/// @source  convolved: METHOD.md 3.1; integral invariants: [LCL17]
Result<NormalField> estimateNormals(const VoxelGrid& grid, const DigitalSurface& surface,
                                    const SurfelLinks& links, const NormalOptions& options,
                                    const RunContext& run);

}  // namespace rivage::core
