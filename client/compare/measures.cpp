#include "client/compare/measures.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <utility>

#include "client/compare/triangle_tree.h"

namespace rivage::client {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

/// Numbers of positions: the same for vertices that lie at the same place. It holds the vertices of
/// some triangles only, as a file may have very many parts.
class PlaceNumbers {
public:
    PlaceNumbers(const Surface& surface, std::size_t first, std::size_t count) {
        vertices_.reserve(3 * count);
        for (std::size_t t = first; t < first + count; ++t)
            vertices_.insert(vertices_.end(), surface.triangles[t].begin(),
                             surface.triangles[t].end());
        std::sort(vertices_.begin(), vertices_.end());
        vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
        const auto key = [&](std::size_t i) {
            const Vector3f& p = surface.positions[vertices_[i]];
            return std::tuple(p.x(), p.y(), p.z());
        };
        std::vector<std::size_t> order(vertices_.size());
        std::iota(order.begin(), order.end(), 0);
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
        numbers_.resize(vertices_.size());
        std::uint32_t next = 0;
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (i > 0 && key(order[i - 1]) < key(order[i])) ++next;
            numbers_[order[i]] = next;
        }
    }
    [[nodiscard]] std::uint32_t of(std::uint32_t vertex) const {
        return numbers_[std::lower_bound(vertices_.begin(), vertices_.end(), vertex) -
                        vertices_.begin()];
    }

private:
    std::vector<std::uint32_t> vertices_;  ///< sorted
    std::vector<std::uint32_t> numbers_;   ///< of each
};

bool isClosed(const Surface& surface, std::size_t first, std::size_t count) {
    const PlaceNumbers numbers(surface, first, count);
    std::vector<std::pair<std::uint64_t, int>> edges;  // both ends, and the way
    edges.reserve(3 * count);
    for (std::size_t t = first; t < first + count; ++t)
        for (int i = 0; i < 3; ++i) {
            std::uint64_t a = numbers.of(surface.triangles[t][i]);
            std::uint64_t b = numbers.of(surface.triangles[t][(i + 1) % 3]);
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
