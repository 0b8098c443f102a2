#pragma once

#include <vector>

#include "tests/support/grids.h"
#include "tests/support/regularized.h"

/// Walls one voxel thick, and what is left of them.
namespace rivage::test {

/// A naive digital plane: the thinnest wall with this normal that no path from face to face of
/// voxels crosses. It goes on behind the border of the grid, so it has no rim.
/// @param normal  coordinates >= 0
[[nodiscard]] VoxelGrid wallGrid(const Vec3i& normal);

/// Directions of walls that the tests look at: along the grid, diagonal and in between.
[[nodiscard]] const std::vector<Vec3i>& wallNormals();

/// The volume of the voxels of a wall over the area of the plane.
[[nodiscard]] inline double idealThickness(const Vec3i& normal) {
    return normal.maxCoeff() / normal.cast<double>().norm();
}

/// What there is to say about the two sides of a wall, away from the border.
struct Sides {
    double thickness = 0;    ///< distance of the mean heights of the two sides along the normal
    double roughness = 0;    ///< rms of the heights about their means
    double normalError = 0;  ///< degrees, mean over the faces
};

[[nodiscard]] Sides measureSides(const Regularized& result, const Vec3i& normal);

}  // namespace rivage::test
