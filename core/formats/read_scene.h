#pragma once

#include <cstddef>
#include <span>

#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Reads a scene in the format that `options.format` names, or, with `automatic`, in the one that
/// the first bytes name: MagicaVoxel (.vox), NumPy (.npy), NRRD, NIfTI or .vol. Raw volumes have no
/// magic and are read only when asked for. What is packed by gzip is unpacked first, but for raw.
/// @errors tooLarge above `maxInputBytes`, also unpacked; malformedInput if there are no bytes;
///         unsupportedFormat if the first bytes name another format, or none; those of `readVox`,
///         `readNpy`, `readNrrd`, `readNifti`, `readVol` and `readRaw`
Result<Scene> readScene(std::span<const std::byte> bytes, const InputOptions& options,
                        const RunContext& run);

}  // namespace rivage::core
