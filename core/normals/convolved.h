#pragma once

#include "core/normals/normal_field.h"
#include "core/normals/patch_walker.h"

namespace rivage::core {

/// The convolved trivial normal of one surfel: the mean of the trivial normals of its patch with
/// hat weights 1 - d / radius, normalized; the trivial normal where they cancel.
///
/// The sum over a patch is its vector area, which depends on the border of the patch only: exact
/// in the mean on any digital plane, and one-sided next to a junction.
/// @source METHOD.md 3.1
[[nodiscard]] Vec3d convolvedNormal(const DigitalSurface& surface, PatchWalker& walker, SurfelId s,
                                    double radius);

}  // namespace rivage::core
