#include "core/mesh/crossing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "core/mesh/diagonal.h"
#include "core/surface/split_umbrellas.h"

namespace rivage::core {
namespace {

using Triangle = std::array<Vec3d, 3>;

constexpr double kTouch = 1e-9;  // shortest sides of a voxel: overlaps below it are rounding

struct Range {
    double low;
    double high;
    Range(const Triangle& triangle, const Vec3d& axis) {
        const Vec3d at(triangle[0].dot(axis), triangle[1].dot(axis), triangle[2].dot(axis));
        low = at.minCoeff();
        high = at.maxCoeff();
    }
};

// Whether a plane across `axis` has the triangles on its two sides. Says nothing, so false, of an
// axis that vanishes.
bool separates(const Vec3d& axis, const Triangle& s, const Triangle& t) {
    const double length = axis.norm();
    if (!(length > kTouch)) return false;
    const Range a(s, axis);
    const Range b(t, axis);
    return std::min(a.high - b.low, b.high - a.low) <= kTouch * length;
}

Vec3d normalOf(const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]); }

bool liesInPlane(const Triangle& t, const Triangle& plane) {
    const Vec3d normal = normalOf(plane).normalized();
    return std::all_of(t.begin(), t.end(), [&](const Vec3d& at) {
        return std::abs(normal.dot(at - plane[0])) <= kTouch;
    });
}

bool trianglesCross(const Triangle& s, const Triangle& t) {
    const Vec3d normal = normalOf(s);
    const bool flat = liesInPlane(t, s);
    if (!flat && (separates(normal, s, t) || separates(normalOf(t), s, t))) return false;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3d ofS = s[(i + 1) % 3] - s[i];
        const Vec3d ofT = t[(i + 1) % 3] - t[i];
        if (flat && (separates(normal.cross(ofS), s, t) || separates(normal.cross(ofT), s, t)))
            return false;
        for (std::size_t j = 0; j < 3 && !flat; ++j)
            if (separates(ofS.cross(t[(j + 1) % 3] - t[j]), s, t)) return false;
    }
    return true;
}

std::array<Triangle, 2> trianglesOf(const DigitalSurface& surface,
                                    const IdVector<PointelId, Vec3d>& positions, SurfelId s) {
    const auto& corners = surface.corners[s];
    const std::uint32_t k = firstCorner(corners, positions);
    const auto at = [&](std::uint32_t i) { return positions[corners[(k + i) & 3U]]; };
    return {Triangle{at(0), at(1), at(2)}, Triangle{at(0), at(2), at(3)}};
}

bool sharePointel(const DigitalSurface& surface, SurfelId s, SurfelId t) {
    const auto& a = surface.corners[s];
    const auto& b = surface.corners[t];
    return std::any_of(a.begin(), a.end(),
                       [&](PointelId p) { return std::find(b.begin(), b.end(), p) != b.end(); });
}

// A face at a split pointel.
struct SplitCorner {
    PointelId pointel;
    SurfelId face;
};

std::vector<SplitCorner> splitCorners(const DigitalSurface& surface) {
    std::vector<SplitCorner> found;
    for (std::uint32_t s = 0; s < surface.surfelCount(); ++s)
        for (const PointelId p : surface.corners[SurfelId{s}])
            if (isSplit(surface, p)) found.push_back({p, SurfelId{s}});
    std::stable_sort(found.begin(), found.end(), [](const SplitCorner& a, const SplitCorner& b) {
        return a.pointel < b.pointel;
    });
    return found;
}

}  // namespace

std::vector<FacePair> touchingFaces(const DigitalSurface& surface) {
    const std::vector<SplitCorner> corners = splitCorners(surface);
    std::vector<FacePair> pairs;
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t j = i + 1; j < corners.size(); ++j) {
            const auto& [p, s] = corners[i];
            const auto& [q, t] = corners[j];
            if (surface.pointels[p] != surface.pointels[q]) break;
            if (p != q && !sharePointel(surface, s, t)) pairs.push_back(std::minmax(s, t));
        }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
}

bool facesCross(const DigitalSurface& surface, const IdVector<PointelId, Vec3d>& positions,
                const FacePair& pair) {
    for (const Triangle& s : trianglesOf(surface, positions, pair.first))
        for (const Triangle& t : trianglesOf(surface, positions, pair.second))
            if (trianglesCross(s, t)) return true;
    return false;
}

std::vector<FacePair> crossingFaces(const DigitalSurface& surface,
                                    const IdVector<PointelId, Vec3d>& positions) {
    std::vector<FacePair> crossing;
    for (const FacePair& pair : touchingFaces(surface))
        if (facesCross(surface, positions, pair)) crossing.push_back(pair);
    return crossing;
}

}  // namespace rivage::core
