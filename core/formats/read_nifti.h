#pragma once

#include <cstddef>
#include <span>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Whether bytes begin like a NIfTI-1 or NIfTI-2 file with its values in it, in either byte order.
[[nodiscard]] bool isNifti(std::span<const std::byte> bytes);

/// Reads a volume of labels from a NIfTI file (.nii), versions 1 and 2: whole numbers, or floating
/// point if all values are whole. The axes are turned to right, forward and up, by the sform, else
/// the qform, else by the sides of a voxel alone.
/// @errors unsupportedFormat for two files (.hdr and .img), other types, scaled values and more than
///         three axes; malformedInput for a broken header or too few values; those of
///         `checkVolumeSize`, `placeVolume` and `sceneFromVolume`
/// @source the NIfTI-1 and NIfTI-2 data formats (nifti1.h, nifti2.h)
Result<Scene> readNifti(std::span<const std::byte> bytes, const RunContext& run);

}  // namespace rivage::core
