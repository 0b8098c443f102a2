#include "client/compare/measures.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>

#include "client/compare/triangle_tree.h"

namespace rivage::client {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// One number a position, for the vertices that the triangles use.
std::vector<std::uint32_t> numberPositions(const Surface& surface, std::size_t first,
                                           std::size_t count) {
    std::vector<std::uint32_t> corners;
    corners.reserve(3 * count);
    for (std::size_t t = first; t < first + count; ++t)
        corners.insert(corners.end(), surface.triangles[t].begin(), surface.triangles[t].end());
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    const auto key = [&](std::uint32_t v) {
        const Vector3f& p = surface.positions[v];
        return std::tuple(p.x(), p.y(), p.z());
    };
    std::sort(corners.begin(), corners.end(),
              [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    std::vector<std::uint32_t> numbers(surface.positions.size());
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (i > 0 && key(corners[i - 1]) < key(corners[i])) ++next;
        numbers[corners[i]] = next;
    }
    return numbers;
}

bool isClosed(const Surface& surface, std::size_t first, std::size_t count) {
    const std::vector<std::uint32_t> numbers = numberPositions(surface, first, count);
    std::vector<std::pair<std::uint64_t, int>> edges;  // both ends, and the way
    edges.reserve(3 * count);
    for (std::size_t t = first; t < first + count; ++t)
        for (int i = 0; i < 3; ++i) {
            std::uint64_t a = numbers[surface.triangles[t][i]];
            std::uint64_t b = numbers[surface.triangles[t][(i + 1) % 3]];
            if (a == b) continue;
            const int way = a < b ? 1 : -1;
            if (a > b) std::swap(a, b);
            edges.emplace_back(a << 32 | b, way);
        }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0; i < edges.size();) {
        int sum = 0;
        const std::uint64_t edge = edges[i].first;
        for (; i < edges.size() && edges[i].first == edge; ++i) sum += edges[i].second;
        if (sum != 0) return false;
    }
    return true;
}

}  // namespace

Measures measure(const Surface& surface, std::size_t first, std::size_t count) {
    Measures out;
    if (count == 0) return out;
    const Vector3d origin = cornersOf(surface, first)[0];
    out.low = origin;
    out.high = origin;
    double volume6 = 0;
    for (std::size_t t = first; t < first + count; ++t) {
        const Triangle corners = cornersOf(surface, t);
        for (const Vector3d& corner : corners) {
            out.low = out.low.cwiseMin(corner);
            out.high = out.high.cwiseMax(corner);
        }
        const Vector3d normal = areaNormal(corners);
        out.area += normal.norm() / 2;
        if (!(normal.squaredNorm() > 0)) ++out.flat;
        volume6 += normal.dot(corners[0] - origin);
    }
    if (isClosed(surface, first, count)) out.volume = volume6 / 6;
    return out;
}

}  // namespace rivage::client
