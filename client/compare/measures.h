#pragma once

#include <optional>
#include <vector>

#include "client/compare/surface.h"

namespace rivage::client {

/// What can be said of some triangles by themselves, in the unit of the file.
struct Measures {
    Eigen::Vector3d low = Eigen::Vector3d::Zero();  ///< of all corners
    Eigen::Vector3d high = Eigen::Vector3d::Zero();
    double area = 0;
    std::size_t flat = 0;          ///< triangles without an area
    std::optional<double> volume;  ///< enclosed; nothing if the triangles are not closed
};

/// Measures the triangles `first` to `first + count`. They are closed if every edge is used as often
/// one way as the other; vertices at the same position are one.
/// @cost  O(n log n) time, 50 bytes a triangle
[[nodiscard]] Measures measure(const Surface& surface, std::size_t first, std::size_t count);

}  // namespace rivage::client
