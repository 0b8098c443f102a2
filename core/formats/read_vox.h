#pragma once

#include <cstddef>
#include <span>

#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Reads a MagicaVoxel file, version 150 or 200, with its scene graph, palette and materials.
/// The material id of a voxel is its stored colour index; transforms are those of
/// `options.frame`; layers, groups and shapes that are hidden stay in the scene and are marked.
///
/// @param bytes  exactly one file; every proper prefix and anything behind MAIN is refused
/// @return       models in file order, instances in the order of the scene graph; a file without
///               a scene graph is one instance whose frames are the models
/// @errors       malformedInput; unsupportedFormat; tooLarge by models, nodes or instances;
///               memoryBudget if the bricks of the models exceed `maxMemory`; emptyGrid if there
///               is no model; cancelled
/// @cost         O(bytes) time; at most 8 KiB per touched brick of 16^3
/// @source       the published format texts; traps in VOXEL-GLTF.md section 1.2
Result<Scene> readVox(std::span<const std::byte> bytes, const InputOptions& options,
                      const RunContext& run);

}  // namespace rivage::core
