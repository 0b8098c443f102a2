#pragma once

#include <cstddef>
#include <span>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Whether bytes begin with the header of a .vol or .longvol file.
[[nodiscard]] bool isVol(std::span<const std::byte> bytes);

/// Reads a volume of labels from a .vol or .longvol file, as DGtal and its gallery of volumes have
/// them: without version, version 2, and version 3 (packed).
/// @errors unsupportedFormat for other versions and widths of values; malformedInput for a broken
///         header, or more or fewer values than it says; those of `checkVolumeSize` and
///         `sceneFromVolume`
/// @source DGtal, VolReader and LongvolReader
Result<Scene> readVol(std::span<const std::byte> bytes, const RunContext& run);

}  // namespace rivage::core
