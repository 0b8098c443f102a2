#pragma once

#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/vec.h"
#include "core/grid/brick_grid.h"
#include "core/grid/material.h"

namespace rivage::core {

/// One label grid: what a voxel stores is a material id, and the material says its label.
struct VoxelGrid {
    BrickGrid voxels;
    Vec3i origin = Vec3i::Zero();  ///< scene coordinates of voxel (0, 0, 0), voxels
    IdVector<MaterialId, Material> materials{1};
    IdVector<Label, std::string> labels{1};  ///< names; entry 0 is the background
    /// The grid is cut out of something larger: regions go on behind its border.
    bool openBorder = false;
    Vec3d spacing = Vec3d::Ones();  ///< sides of a voxel; the shortest is 1

    [[nodiscard]] Label labelAt(const Vec3i& voxel) const {
        return materials[voxels.at(voxel)].label;
    }
};

}  // namespace rivage::core
