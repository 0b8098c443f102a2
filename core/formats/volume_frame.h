#pragma once

#include <array>
#include <string>

#include "core/base/result.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Steps of one voxel along the three axes of a file, in a space with x to the right, y forward and
/// z up; any unit of length.
using VolumeSteps = std::array<Vec3d, 3>;

/// Turns the volume of a scene so that its axes are those of space, and sets the sides of a voxel.
/// What is turned by less than a right angle keeps its own axes, and a warning tells by how much.
/// @param scene  of one model, as `sceneFromVolume` makes it
/// @param field  of the header, for errors
/// @errors malformedInput if a step has no finite length, two go the same way, or one is more than
///         `kMaxSpacingRatio` times another
Result<void> placeVolume(Scene& scene, const VolumeSteps& steps, const std::string& field);

}  // namespace rivage::core
