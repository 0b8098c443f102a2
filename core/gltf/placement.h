#pragma once

#include "core/base/options.h"
#include "core/base/vec.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// The way from scene coordinates (voxels, z up) to those of the output (metres, `up`): the pivot
/// goes to the origin. Every writer uses it, and nothing else scales or turns.
struct Placement {
    Vec3d pivot = Vec3d::Zero();  ///< scene coordinates
    double scale = 1;             ///< metres a voxel
    UpAxis up = UpAxis::y;

    [[nodiscard]] Vec3d direction(const Vec3d& scene) const {
        return up == UpAxis::y ? Vec3d(scene.x(), scene.z(), -scene.y()) : scene;
    }
    /// Rounded to float here, once, so that equal positions stay equal in every part.
    [[nodiscard]] Vec3f position(const Vec3d& scene) const {
        return (scale * direction(scene - pivot)).cast<float>();
    }
};

/// The placement that the options ask for. The pivot refers to the box of the voxels, so it does
/// not depend on how far the surface moved.
[[nodiscard]] Placement placementOf(const Mesh& mesh, const OutputOptions& options);

}  // namespace rivage::core
