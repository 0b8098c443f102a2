#pragma once

#include "core/base/vec.h"

namespace rivage::core {

/// Tile coordinates as linear functions of the position, in voxels: u = u . x, v = v . x.
struct TileFrame {
    Vec3d u = Vec3d::UnitX();
    Vec3d v = Vec3d::UnitY();
    bool slope = false;  ///< neither a wall nor level ground
    bool operator==(const TileFrame&) const = default;
};

/// The frame of a face: box mapping with more than six sides. u runs horizontally to the right seen
/// from outside, v up the slope (+z on walls, +y on level ground), and both are aligned with the
/// world, so one wall or roof has one frame, and where its parts continue each other the tile does.
///
/// Directions come in steps of 45 degrees about z and of slope: a length differs from the one on
/// the surface by 9 % at most, and 16 % where both are between steps. The borders between steps lie
/// away from the slopes that voxels draw: 1:1, 1:2, 1:3 and flat.
/// @param normal  of the surface there, unit, pointing outwards
/// @source ours
[[nodiscard]] TileFrame tileFrame(const Vec3d& normal);

}  // namespace rivage::core
