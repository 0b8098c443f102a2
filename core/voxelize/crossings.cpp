#include "core/voxelize/crossings.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "core/mesh/diagonal.h"

namespace rivage::core {
namespace {

using Vec3l = Eigen::Matrix<std::int64_t, 3, 1>;

/// Counter-clockwise seen from above.
struct Triangle {
    std::array<Vec3l, 3> corners;
    Label from;  // below
    Label to;    // above
};

template <typename Wide>
Wide cross(const Vec3l& a, const Vec3l& b, std::int64_t x, std::int64_t y) {
    return Wide{b.x() - a.x()} * (y - a.y()) - Wide{b.y() - a.y()} * (x - a.x());
}

/// Whether a column on the edge a b, stepped off by (e, e^2), lies left of it.
bool takesEdge(const Vec3l& a, const Vec3l& b) {
    return b.y() < a.y() || (b.y() == a.y() && b.x() > a.x());
}

/// The first sample at or above the plane of a triangle, where `weights` are the barycentric
/// coordinates of the column times `area`.
template <typename Wide>
std::int64_t sampleAbove(const Triangle& triangle, const std::array<Wide, 3>& weights,
                         const Wide& area, const SampleLattice& lattice) {
    std::int64_t low = triangle.corners[0].z();
    for (const Vec3l& corner : triangle.corners) low = std::min(low, corner.z());
    const std::int64_t base = lattice.firstFrom(low);
    // From the sample `base` down to the height: at most one step and the triangle's own height.
    Wide above = area * (low - (lattice.at(0) + base * lattice.step()));
    for (int i = 0; i < 3; ++i) above += weights[i] * (triangle.corners[i].z() - low);
    const Wide step = area * lattice.step();
    return above <= 0 ? base : base + static_cast<std::int64_t>((above + step - 1) / step);
}

template <typename Wide>
void scan(const Triangle& triangle, const SampleLattice& lattice, const SampleRange& clip,
          const ColumnBlock& block, std::vector<Crossing>& crossings) {
    const auto& [a, b, c] = triangle.corners;
    const Wide area = cross<Wide>(a, b, c.x(), c.y());
    const std::array<bool, 3> takes = {takesEdge(b, c), takesEdge(c, a), takesEdge(a, b)};
    for (int y = clip.yBegin; y <= clip.yLast; ++y)
        for (int x = clip.xBegin; x <= clip.xLast; ++x) {
            const std::int64_t px = lattice.at(x);
            const std::int64_t py = lattice.at(y);
            const std::array<Wide, 3> weights = {
                cross<Wide>(b, c, px, py), cross<Wide>(c, a, px, py), cross<Wide>(a, b, px, py)};
            bool inside = true;
            for (int i = 0; i < 3; ++i)
                inside = inside && (weights[i] > 0 || (weights[i] == 0 && takes[i]));
            if (!inside) continue;
            const std::int64_t sample = sampleAbove<Wide>(triangle, weights, area, lattice);
            if (sample >= lattice.size.z()) continue;
            crossings.push_back({x - block.x + ColumnBlock::kSide * (y - block.y),
                                 static_cast<std::int32_t>(std::max<std::int64_t>(sample, 0)),
                                 triangle.from, triangle.to});
        }
}

/// Turns a triangle to be counter-clockwise seen from above.
/// @return false if it is seen edge-on: no column passes it
bool turnUp(Triangle& triangle) {
    const auto& [a, b, c] = triangle.corners;
    const Int128 area = cross<Int128>(a, b, c.x(), c.y());
    if (area < 0) {
        std::swap(triangle.corners[1], triangle.corners[2]);
        std::swap(triangle.from, triangle.to);
    }
    return area != 0;
}

/// Whether products of three differences within a face fit 64 bits.
bool isSmall(const std::array<Vec3l, 4>& corners, const SampleLattice& lattice) {
    constexpr std::int64_t kSmall = std::int64_t{1} << 20;
    Vec3l low = corners[0];
    Vec3l high = corners[0];
    for (const Vec3l& corner : corners) {
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
    }
    return (high - low).maxCoeff() < kSmall && lattice.step() < kSmall;
}

int clampSample(std::int64_t sample) {
    constexpr std::int64_t kFar = std::numeric_limits<int>::max() / 2;
    return static_cast<int>(std::clamp(sample, -kFar, kFar));
}

}  // namespace

SampleRange samplesUnder(const MovedSurface& moved, SurfelId s, const SampleLattice& lattice) {
    const auto& corners = moved.surface.corners[s];
    Vec3i low = moved.snapped[corners[0]];
    Vec3i high = low;
    for (const PointelId p : corners) {
        low = low.cwiseMin(moved.snapped[p]);
        high = high.cwiseMax(moved.snapped[p]);
    }
    const auto first = [&](int axis) {
        return std::max(0, clampSample(lattice.firstFrom(std::int64_t{low[axis]} * lattice.up)));
    };
    const auto last = [&](int axis) {
        const std::int64_t end = lattice.firstFrom(std::int64_t{high[axis]} * lattice.up + 1);
        return std::min(lattice.size[axis], clampSample(end)) - 1;
    };
    return {first(0), last(0), first(1), last(1)};
}

void appendCrossings(const MovedSurface& moved, SurfelId s, const SampleLattice& lattice,
                     const ColumnBlock& block, std::vector<Crossing>& crossings) {
    const SampleRange under = samplesUnder(moved, s, lattice);
    const SampleRange clip{
        std::max(under.xBegin, block.x), std::min(under.xLast, block.x + ColumnBlock::kSide - 1),
        std::max(under.yBegin, block.y), std::min(under.yLast, block.y + ColumnBlock::kSide - 1)};
    if (clip.xBegin > clip.xLast || clip.yBegin > clip.yLast) return;
    const auto& pointels = moved.surface.corners[s];
    const std::uint32_t k = firstCorner(pointels, moved.positions);
    std::array<Vec3l, 4> corners;
    for (std::uint32_t i = 0; i < 4; ++i)
        corners[i] = moved.snapped[pointels[(k + i) % 4]].cast<std::int64_t>() * lattice.up;
    const bool small = isSmall(corners, lattice);
    const LabelPair labels = moved.labels(s);
    // Seen from above the outer label is nearer: the inner one is below.
    for (const std::uint32_t second : {1U, 2U}) {
        Triangle triangle{
            {corners[0], corners[second], corners[second + 1]}, labels.inner, labels.outer};
        if (!turnUp(triangle)) continue;
        if (small)
            scan<std::int64_t>(triangle, lattice, clip, block, crossings);
        else
            scan<Int128>(triangle, lattice, clip, block, crossings);
    }
}

}  // namespace rivage::core
