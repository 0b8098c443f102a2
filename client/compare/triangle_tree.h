#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "client/compare/surface.h"
#include "client/compare/triangle.h"

namespace rivage::client {

/// The corners of a triangle of a surface.
[[nodiscard]] Triangle cornersOf(const Surface& surface, std::size_t triangle);

/// A tree of boxes over some triangles of a surface that finds the closest one. The answer does not
/// depend on the shape of the tree: it is the same as that of a loop over all triangles.
class TriangleTree {
public:
    /// What a search found; also the memory of the next search, which is faster near the last one.
    struct Search {
        struct Tie {
            std::uint32_t triangle = 0;  ///< of the surface
            Eigen::Vector3d point;       ///< of the triangle, closest to the place
            double distance2 = 0;
        };
        double distance2 = 0;
        double reach2 = 0;  ///< triangles beyond do not matter
        /// The triangles that are as close as the closest, up to the tolerance; unordered.
        std::vector<Tie> ties;
        std::uint32_t start = 0;  ///< the triangle that the search begins with
    };

    /// @param triangles  indices into `surface`, at least one, all with an area
    /// @param tolerance  a length above zero: distances that differ by less are equal
    /// @cost  O(n log n) time, 70 bytes a triangle
    TriangleTree(const Surface& surface, const std::vector<std::uint32_t>& triangles,
                 double tolerance);

    /// The distance from a place to the closest triangle.
    void closest(const Eigen::Vector3d& place, Search& search) const;

private:
    struct Node {
        Eigen::Vector3f low;
        Eigen::Vector3f high;
        std::uint32_t first = 0;  ///< triangle of a leaf, else its second child; the first follows
        std::uint32_t count = 0;  ///< 0 for a node with children
    };
    struct Item {
        Eigen::Vector3f middle;
        std::uint32_t triangle;
    };

    void build(const Surface& surface, std::span<Item> items);
    void addLeaf(const Surface& surface, std::span<const Item> items, Node& node);
    void visit(std::uint32_t slot, const Eigen::Vector3d& place, Search& search) const;
    [[nodiscard]] double reach(double distance2) const;

    std::vector<std::array<Eigen::Vector3f, 3>> corners_;  ///< in the order of the leaves
    std::vector<std::uint32_t> triangles_;
    std::vector<Node> nodes_;
    double tolerance_;
};

}  // namespace rivage::client
