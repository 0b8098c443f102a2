#include "client/compare/triangle_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace rivage::client {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr std::size_t kLeaf = 4;        ///< triangles
constexpr std::size_t kMostDepth = 64;  ///< halves of a list of 2^32 are at depth 32

double boxDistance2(const Vector3f& low, const Vector3f& high, const Vector3d& place) {
    return (low.cast<double>() - place)
        .cwiseMax(place - high.cast<double>())
        .cwiseMax(0)
        .squaredNorm();
}

}  // namespace

Triangle cornersOf(const Surface& surface, std::size_t triangle) {
    const auto& v = surface.triangles[triangle];
    return {surface.positions[v[0]].cast<double>(), surface.positions[v[1]].cast<double>(),
            surface.positions[v[2]].cast<double>()};
}

TriangleTree::TriangleTree(const Surface& surface, const std::vector<std::uint32_t>& triangles,
                           double tolerance)
    : tolerance_(tolerance) {
    std::vector<Item> items;
    items.reserve(triangles.size());
    for (const std::uint32_t t : triangles) {
        const Triangle corners = cornersOf(surface, t);
        items.push_back({((corners[0] + corners[1] + corners[2]) / 3).cast<float>(), t});
    }
    corners_.reserve(items.size());
    triangles_.reserve(items.size());
    nodes_.reserve(items.size());
    build(surface, items);
}

void TriangleTree::build(const Surface& surface, std::span<Item> items) {
    const std::size_t node = nodes_.size();
    nodes_.emplace_back();
    if (items.size() <= kLeaf) return addLeaf(surface, items, nodes_[node]);
    Vector3f low = items.front().middle;
    Vector3f high = low;
    for (const Item& item : items) {
        low = low.cwiseMin(item.middle);
        high = high.cwiseMax(item.middle);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t half = items.size() / 2;
    std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                     [axis](const Item& a, const Item& b) {
                         return std::pair(a.middle[axis], a.triangle) <
                                std::pair(b.middle[axis], b.triangle);
                     });
    build(surface, items.first(half));
    const auto second = static_cast<std::uint32_t>(nodes_.size());
    build(surface, items.subspan(half));
    nodes_[node].first = second;
    nodes_[node].low = nodes_[node + 1].low.cwiseMin(nodes_[second].low);
    nodes_[node].high = nodes_[node + 1].high.cwiseMax(nodes_[second].high);
}

void TriangleTree::addLeaf(const Surface& surface, std::span<const Item> items, Node& node) {
    node.first = static_cast<std::uint32_t>(triangles_.size());
    node.count = static_cast<std::uint32_t>(items.size());
    node.low.setConstant(std::numeric_limits<float>::infinity());
    node.high = -node.low;
    for (const Item& item : items) {
        const auto& v = surface.triangles[item.triangle];
        triangles_.push_back(item.triangle);
        corners_.push_back(
            {surface.positions[v[0]], surface.positions[v[1]], surface.positions[v[2]]});
        for (const Vector3f& corner : corners_.back()) {
            node.low = node.low.cwiseMin(corner);
            node.high = node.high.cwiseMax(corner);
        }
    }
}

double TriangleTree::reach(double distance2) const {
    const double distance = std::sqrt(distance2) + tolerance_;
    return distance * distance;
}

void TriangleTree::visit(std::uint32_t slot, const Vector3d& place, Search& search) const {
    const auto& c = corners_[slot];
    const Vector3d point =
        closestOnTriangle(place, {c[0].cast<double>(), c[1].cast<double>(), c[2].cast<double>()});
    const double distance2 = (point - place).squaredNorm();
    if (distance2 > search.reach2) return;
    if (distance2 < search.distance2) {
        search.distance2 = distance2;
        search.reach2 = reach(distance2);
        search.start = slot;
    }
    search.ties.push_back({triangles_[slot], point, distance2});
}

void TriangleTree::closest(const Vector3d& place, Search& search) const {
    search.ties.clear();
    search.distance2 = std::numeric_limits<double>::infinity();
    search.reach2 = search.distance2;
    const std::uint32_t start =
        std::min(search.start, static_cast<std::uint32_t>(triangles_.size() - 1));
    visit(start, place, search);

    std::array<std::uint32_t, kMostDepth> open{};
    std::size_t count = 0;
    open[count++] = 0;
    while (count > 0) {
        const std::uint32_t index = open[--count];
        const Node& node = nodes_[index];
        if (boxDistance2(node.low, node.high, place) > search.reach2) continue;
        for (std::uint32_t i = 0; i < node.count; ++i)
            if (node.first + i != start) visit(node.first + i, place, search);
        if (node.count > 0) continue;
        const std::uint32_t left = index + 1;
        const bool leftFirst = boxDistance2(nodes_[left].low, nodes_[left].high, place) <
                               boxDistance2(nodes_[node.first].low, nodes_[node.first].high, place);
        open[count++] = leftFirst ? node.first : left;
        open[count++] = leftFirst ? left : node.first;
    }
    std::erase_if(search.ties, [&](const auto& tie) { return tie.distance2 > search.reach2; });
}

}  // namespace rivage::client
