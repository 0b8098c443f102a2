#include "core/mesh/crossing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numeric>

#include "core/base/parallel.h"
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

// By pointel, then by face.
std::vector<SplitCorner> splitCorners(const DigitalSurface& surface, const RunContext& run) {
    std::vector<std::uint32_t> next(surface.pointelCount() + 1);
    const auto forEachCorner = [&](auto&& visit) {
        serialFor(surface.surfelCount(), run, [&](std::size_t i) {
            const SurfelId s{static_cast<std::uint32_t>(i)};
            for (const PointelId p : surface.corners[s])
                if (isSplit(surface, p)) visit(p, s);
        });
    };
    forEachCorner([&](PointelId p, SurfelId) { ++next[index(p) + 1U]; });
    std::partial_sum(next.begin(), next.end(), next.begin());
    std::vector<SplitCorner> found(next.back());
    forEachCorner([&](PointelId p, SurfelId s) { found[next[index(p)]++] = {p, s}; });
    return found;
}

// Sorts, and drops what is there twice. By the first face without comparisons: a sort of millions
// of pairs could not be stopped.
std::vector<FacePair> sortedOnce(const std::vector<FacePair>& pairs, std::size_t faces,
                                 const RunContext& run) {
    std::vector<std::uint32_t> start(faces + 1);
    serialFor(pairs.size(), run, [&](std::size_t i) { ++start[index(pairs[i].first) + 1U]; });
    std::partial_sum(start.begin(), start.end(), start.begin());
    std::vector<FacePair> sorted(pairs.size());
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
    serialFor(pairs.size(), run,
              [&](std::size_t i) { sorted[next[index(pairs[i].first)]++] = pairs[i]; });
    serialFor(faces, run, [&](std::size_t f) {
        std::sort(sorted.begin() + start[f], sorted.begin() + start[f + 1]);
    });
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    return sorted;
}

}  // namespace

std::vector<FacePair> touchingFaces(const DigitalSurface& surface, const RunContext& run) {
    const std::vector<SplitCorner> corners = splitCorners(surface, run);
    std::vector<FacePair> pairs;
    serialFor(corners.size(), run, [&](std::size_t i) {
        for (std::size_t j = i + 1; j < corners.size(); ++j) {
            const auto& [p, s] = corners[i];
            const auto& [q, t] = corners[j];
            if (surface.pointels[p] != surface.pointels[q]) break;
            if (p != q && !sharePointel(surface, s, t)) pairs.push_back(std::minmax(s, t));
        }
    });
    return sortedOnce(pairs, surface.surfelCount(), run);
}

bool facesCross(const DigitalSurface& surface, const IdVector<PointelId, Vec3d>& positions,
                const FacePair& pair) {
    for (const Triangle& s : trianglesOf(surface, positions, pair.first))
        for (const Triangle& t : trianglesOf(surface, positions, pair.second))
            if (trianglesCross(s, t)) return true;
    return false;
}

std::vector<FacePair> crossingFaces(const DigitalSurface& surface,
                                    const IdVector<PointelId, Vec3d>& positions,
                                    const RunContext& run) {
    const std::vector<FacePair> pairs = touchingFaces(surface, run);
    std::vector<FacePair> crossing;
    serialFor(pairs.size(), run, [&](std::size_t i) {
        if (facesCross(surface, positions, pairs[i])) crossing.push_back(pairs[i]);
    });
    return crossing;
}

}  // namespace rivage::core
