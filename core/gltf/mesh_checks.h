#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/gltf/placement.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// What every writer asks of a mesh before it starts.
/// @errors  emptyGrid if the mesh has no face; internal if a position or normal is not finite
Result<void> checkMesh(const Mesh& mesh, const Placement& placement, const RunContext& run);

/// @errors  outputTooLarge if `bytes` is above `limit`
Result<void> checkOutputBytes(std::uint64_t bytes, std::uint64_t limit);

}  // namespace rivage::core
