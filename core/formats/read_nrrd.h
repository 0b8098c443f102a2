#pragma once

#include <cstddef>
#include <span>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Reads a volume of labels from an NRRD file with its values attached: raw, gzip or text, of any
/// whole-number type, or floating point if all values are whole. Names and colours of 3D Slicer's
/// segments become those of the materials; the axes are turned to right, forward and up.
/// @errors those of `parseNrrdHeader`, `checkVolumeSize`, `placeVolume` and `sceneFromVolume`;
///         malformedInput if there are more or fewer values than the sizes say
/// @cost   as `sceneFromVolume`, and the unpacked values in memory
Result<Scene> readNrrd(std::span<const std::byte> bytes, const RunContext& run);

}  // namespace rivage::core
