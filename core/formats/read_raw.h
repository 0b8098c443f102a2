#pragma once

#include <cstddef>
#include <span>

#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Reads a headerless volume of labels: `options.dims` values of `options.rawType`, little-endian,
/// x fastest, then y, then z. 0 is empty; see `sceneFromVolume` for the materials.
/// @errors invalidOption without dims or below 1; malformedInput if the byte count does not match;
///         tooLarge if dims ask for more than the limits, before anything is allocated; those of
///         `sceneFromVolume`
Result<Scene> readRaw(std::span<const std::byte> bytes, const InputOptions& options,
                      const RunContext& run);

}  // namespace rivage::core
