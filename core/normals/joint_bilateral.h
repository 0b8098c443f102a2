#pragma once

#include "core/normals/normal_field.h"
#include "core/normals/patch_walker.h"

namespace rivage::core {

/// A window of the joint bilateral mean.
struct BilateralWindow {
    double radius = 5;   ///< in units of the shortest side of a voxel
    double angle = 0.5;  ///< radians: guide normals that differ by more hardly count
    /// Fits the normals linearly over the window instead of taking their mean, so that a window
    /// that lies to one side of a crease or a junction is not biased where the surface is curved.
    bool linear = false;
};

/// The mean of the trivial normals around a surfel, each with the hat weight of its distance and
/// with a Gaussian of the angle between its guide normal and the surfel's own: the window takes
/// what lies on the same side of a crease.
/// @param guide  unit vectors
/// @return  unit
/// @cost    one patch
/// @source  joint bilateral filtering as in [ZDZ15], of trivial normals; ours: the linear fit
Vec3d bilateralNormal(const DigitalSurface& surface, const NormalField& guide, PatchWalker& walker,
                      SurfelId s, const BilateralWindow& window);

}  // namespace rivage::core
