#include "tests/support/intersections.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/mesh/diagonal.h"

namespace rivage::test {
namespace {

constexpr double kDepth = 1e-7;

Vec3d unitNormal(const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]).normalized(); }

/// Distance of a point of the plane of `t` to the nearest side of `t`, positive inside.
double depthInside(const Triangle& t, const Vec3d& point) {
    double depth = 1e300;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d inwards = unitNormal(t).cross(t[(i + 1) % 3] - t[i]).normalized();
        depth = std::min(depth, inwards.dot(point - t[i]));
    }
    return depth;
}

bool anEdgePierces(const Triangle& s, const Triangle& t) {
    const Vec3d normal = unitNormal(t);
    for (std::size_t i = 0; i < 3; ++i) {
        const double from = normal.dot(s[i] - t[0]);
        const double to = normal.dot(s[(i + 1) % 3] - t[0]);
        if (std::min(from, to) > -kDepth || std::max(from, to) < kDepth) continue;
        const Vec3d at = s[i] + (s[(i + 1) % 3] - s[i]) * (from / (from - to));
        if (depthInside(t, at) > kDepth) return true;
    }
    return false;
}

bool liesInPlane(const Triangle& s, const Triangle& t) {
    return std::all_of(s.begin(), s.end(), [&](const Vec3d& at) {
        return std::abs(unitNormal(t).dot(at - t[0])) <= kDepth;
    });
}

/// Of two triangles in one plane: no side of `t` has all of `s` beyond it.
bool noSideSeparates(const Triangle& s, const Triangle& t) {
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d inwards = unitNormal(t).cross(t[(i + 1) % 3] - t[i]).normalized();
        if (std::all_of(s.begin(), s.end(),
                        [&](const Vec3d& at) { return inwards.dot(at - t[i]) <= kDepth; }))
            return false;
    }
    return true;
}

std::array<Triangle, 2> trianglesOf(const DigitalSurface& surface, const PointelVectors& x,
                                    SurfelId s) {
    const auto& c = surface.corners[s];
    const std::uint32_t k = firstCorner(c, x);
    const auto at = [&](std::uint32_t i) { return x[c[(k + i) % 4]]; };
    return {Triangle{at(0), at(1), at(2)}, Triangle{at(0), at(2), at(3)}};
}

bool facesIntersect(const DigitalSurface& surface, const PointelVectors& x, SurfelId f,
                    SurfelId g) {
    for (const PointelId p : surface.corners[f])
        for (const PointelId q : surface.corners[g])
            if (p == q) return false;
    for (const Triangle& s : trianglesOf(surface, x, f))
        for (const Triangle& t : trianglesOf(surface, x, g))
            if (trianglesIntersect(s, t)) return true;
    return false;
}

struct InCell {
    std::array<int, 3> cell;
    SurfelId face;
    auto operator<=>(const InCell&) const = default;
};

std::vector<InCell> facesByCell(const DigitalSurface& surface, const PointelVectors& x) {
    std::vector<InCell> cells;
    for (std::uint32_t f = 0; f < surface.surfelCount(); ++f) {
        const auto& c = surface.corners[SurfelId{f}];
        const Vec3d low = x[c[0]].cwiseMin(x[c[1]]).cwiseMin(x[c[2]]).cwiseMin(x[c[3]]);
        const Vec3d high = x[c[0]].cwiseMax(x[c[1]]).cwiseMax(x[c[2]]).cwiseMax(x[c[3]]);
        const Vec3i from = low.array().floor().matrix().cast<int>();
        const Vec3i to = high.array().floor().matrix().cast<int>();
        for (int k = from.z(); k <= to.z(); ++k)
            for (int j = from.y(); j <= to.y(); ++j)
                for (int i = from.x(); i <= to.x(); ++i) cells.push_back({{i, j, k}, SurfelId{f}});
    }
    std::sort(cells.begin(), cells.end());
    return cells;
}

}  // namespace

bool trianglesIntersect(const Triangle& s, const Triangle& t) {
    if (liesInPlane(s, t)) return noSideSeparates(s, t) && noSideSeparates(t, s);
    return anEdgePierces(s, t) || anEdgePierces(t, s);
}

std::size_t countIntersections(const DigitalSurface& surface, const PointelVectors& positions) {
    const std::vector<InCell> cells = facesByCell(surface, positions);
    std::vector<std::pair<SurfelId, SurfelId>> found;
    for (std::size_t i = 0; i < cells.size(); ++i)
        for (std::size_t j = i + 1; j < cells.size() && cells[j].cell == cells[i].cell; ++j)
            if (facesIntersect(surface, positions, cells[i].face, cells[j].face))
                found.emplace_back(cells[i].face, cells[j].face);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found.size();
}

}  // namespace rivage::test
