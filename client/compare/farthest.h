#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/compare/triangle_tree.h"

namespace rivage::client {

/// The point of a surface that is farthest from another one.
struct Farthest {
    double distance = 0;  ///< of `at`: there is a point that far
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    double atMost = 0;  ///< no point is farther
};

struct FarthestSettings {
    double enough = 0.005;  ///< relative: a gap between `distance` and `atMost` to be content with
    double zero = 0;        ///< a length that is as good as none
    std::size_t searches = 200'000;  ///< at most so many, beside one for each triangle
    unsigned threads = 1;
};

/// Improves a guess of the farthest point by branch and bound: the distance to one triangle is a
/// convex function, so on a piece of `a` it is largest at a corner, and the distance to all of the
/// triangles of `b` is not larger. Pieces where that could be more than what is known are cut in
/// four, until the two bounds meet or the searches are used up.
/// @param triangles  of `a`
/// @param tree       of triangles of `b`
/// @param known      a point of `a` with its distance
/// @return  the same bits for any number of threads
[[nodiscard]] Farthest findFarthest(const Surface& a, const std::vector<std::uint32_t>& triangles,
                                    const Surface& b, const TriangleTree& tree,
                                    const Farthest& known, const FarthestSettings& settings);

}  // namespace rivage::client
