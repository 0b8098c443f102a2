#include "client/compare/distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "client/compare/blocks.h"
#include "client/compare/triangle_tree.h"

namespace rivage::client {
namespace {

using Eigen::Vector3d;
using Search = TriangleTree::Search;

/// What the largest distance may cost, beside the samples; rarely used up.
constexpr std::size_t kSearchesPerSample = 4;
constexpr double kDegrees = 57.295779513082321;
/// sRGB steps of 8 bits: a value that was rounded once in each file differs by one.
constexpr double kColorStep = 1.5 / 255;

std::vector<std::uint32_t> trianglesWithArea(const Surface& surface, std::size_t part) {
    const bool whole = part == DistanceSamples::kWhole;
    const std::size_t first = whole ? 0 : surface.parts[part].first;
    const std::size_t count = whole ? surface.triangles.size() : surface.parts[part].count;
    std::vector<std::uint32_t> triangles;
    triangles.reserve(count);
    for (std::size_t t = first; t < first + count; ++t)
        if (areaNormal(cornersOf(surface, t)).squaredNorm() > 0)
            triangles.push_back(static_cast<std::uint32_t>(t));
    return triangles;
}

/// Leaves out triangles that another one already stands for: the same corners in the same turn, of
/// the same colours. A search would find them all at every place, however many there are.
std::vector<std::uint32_t> withoutCopies(const Surface& surface,
                                         std::vector<std::uint32_t> triangles) {
    using Corner = std::array<float, 6>;
    const auto key = [&](std::uint32_t t) {
        std::array<Corner, 3> corners;
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t v = surface.triangles[t][i];
            const Eigen::Vector3f& p = surface.positions[v];
            const Eigen::Vector3f c =
                surface.colors.empty() ? Eigen::Vector3f::Zero() : surface.colors[v];
            corners[i] = {p.x(), p.y(), p.z(), c.x(), c.y(), c.z()};
        }
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
        return corners;
    };
    std::vector<std::pair<std::array<Corner, 3>, std::uint32_t>> keys;
    keys.reserve(triangles.size());
    for (const std::uint32_t t : triangles) keys.emplace_back(key(t), t);
    std::sort(keys.begin(), keys.end());
    triangles.clear();
    for (std::size_t i = 0; i < keys.size(); ++i)
        if (i == 0 || keys[i].first != keys[i - 1].first) triangles.push_back(keys[i].second);
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

std::vector<std::uint32_t> verticesOf(const Surface& surface,
                                      const std::vector<std::uint32_t>& triangles) {
    std::vector<std::uint32_t> vertices;
    vertices.reserve(3 * triangles.size());
    for (const std::uint32_t t : triangles)
        vertices.insert(vertices.end(), surface.triangles[t].begin(), surface.triangles[t].end());
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

/// A point of a surface: weights of the corners of a triangle.
struct SurfacePoint {
    std::uint32_t triangle = 0;
    Vector3d weights;
};

Vector3d positionOf(const Surface& surface, const SurfacePoint& point) {
    const Triangle corners = cornersOf(surface, point.triangle);
    return point.weights[0] * corners[0] + point.weights[1] * corners[1] +
           point.weights[2] * corners[2];
}

double srgb(double linear) {
    const double v = std::clamp(linear, 0.0, 1.0);
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

/// As people see it: sRGB from 0 to 1.
Vector3d colorOf(const Surface& surface, const SurfacePoint& point) {
    Vector3d color = Vector3d::Zero();
    for (int i = 0; i < 3; ++i)
        color +=
            point.weights[i] * surface.colors[surface.triangles[point.triangle][i]].cast<double>();
    return {srgb(color[0]), srgb(color[1]), srgb(color[2])};
}

/// Points that are even by area: equal steps along the sum of the areas, and inside of a triangle
/// the sequence of the plastic number, which fills the square evenly from any start.
class Sampler {
public:
    Sampler(const Surface& surface, const std::vector<std::uint32_t>& triangles)
        : triangles_(triangles) {
        sums_.reserve(triangles.size());
        double sum = 0;
        for (const std::uint32_t t : triangles) {
            sum += areaNormal(cornersOf(surface, t)).norm();
            sums_.push_back(sum);
        }
    }
    [[nodiscard]] double area() const { return sums_.back() / 2; }

    [[nodiscard]] SurfacePoint point(std::size_t i, std::size_t count) const {
        const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
        const auto found = std::lower_bound(sums_.begin(), sums_.end(), at * sums_.back());
        const auto slot = std::min<std::size_t>(found - sums_.begin(), sums_.size() - 1);
        const double u = std::sqrt(fraction(0.5 + 0.75487766624669276 * static_cast<double>(i)));
        const double v = fraction(0.5 + 0.56984029099805327 * static_cast<double>(i));
        return {triangles_[slot], {1 - u, u * (1 - v), u * v}};
    }

private:
    static double fraction(double value) { return value - std::floor(value); }

    const std::vector<std::uint32_t>& triangles_;
    std::vector<double> sums_;
};

/// One pair of parts, ready to be measured.
struct Pair {
    const Surface& a;
    const Surface& b;
    const TriangleTree& tree;
};

double distanceOf(const Search& search, const DistanceSettings& settings) {
    const double distance = std::sqrt(search.distance2);
    return distance <= settings.zero ? 0 : distance;
}

double angleTo(const Pair& pair, const SurfacePoint& point, const Search& search) {
    const Vector3d own = areaNormal(cornersOf(pair.a, point.triangle)).normalized();
    double best = 180;
    for (const Search::Tie& tie : search.ties) {
        const Vector3d other = areaNormal(cornersOf(pair.b, tie.triangle)).normalized();
        const double angle = std::atan2(own.cross(other).norm(), own.dot(other));
        best = std::min(best, kDegrees * angle);
    }
    return best;
}

bool hasOtherColor(const Pair& pair, const SurfacePoint& point, const Search& search) {
    const Vector3d own = colorOf(pair.a, point);
    return std::none_of(search.ties.begin(), search.ties.end(), [&](const Search::Tie& tie) {
        const SurfacePoint there{tie.triangle,
                                 weightsIn(cornersOf(pair.b, tie.triangle), tie.point)};
        return (colorOf(pair.b, there) - own).cwiseAbs().maxCoeff() <= kColorStep;
    });
}

void measureSamples(const Pair& pair, const Sampler& sampler, const DistanceSettings& settings,
                    DistanceSamples& out) {
    const DistanceSamples::Row& row = out.rows.back();
    const bool colors = !pair.a.colors.empty() && !pair.b.colors.empty();
    out.distances.resize(row.firstSample + row.samples);
    out.degrees.resize(out.distances.size());
    if (colors) out.otherColor.resize(out.distances.size());
    forBlocks(row.samples, settings.threads, [&](std::size_t from, std::size_t to) {
        Search search;
        for (std::size_t i = from; i < to; ++i) {
            const SurfacePoint point = sampler.point(i, row.samples);
            const std::size_t slot = row.firstSample + i;
            pair.tree.closest(positionOf(pair.a, point), search);
            out.distances[slot] = distanceOf(search, settings);
            out.degrees[slot] = angleTo(pair, point, search);
            if (colors) out.otherColor[slot] = hasOtherColor(pair, point, search) ? 1 : 0;
        }
    });
}

/// The farthest of the vertices and the samples, and the first of them that is.
Farthest farthestKnown(const Pair& pair, const Sampler& sampler,
                       const std::vector<std::uint32_t>& vertices, const DistanceSettings& settings,
                       const DistanceSamples& out) {
    std::vector<double> distances(vertices.size());
    forBlocks(vertices.size(), settings.threads, [&](std::size_t from, std::size_t to) {
        Search search;
        for (std::size_t i = from; i < to; ++i) {
            pair.tree.closest(pair.a.positions[vertices[i]].cast<double>(), search);
            distances[i] = distanceOf(search, settings);
        }
    });
    const auto vertex = std::max_element(distances.begin(), distances.end());
    const DistanceSamples::Row& row = out.rows.back();
    const auto first = out.distances.begin() + static_cast<std::ptrdiff_t>(row.firstSample);
    const auto sample = std::max_element(first, out.distances.end());
    if (*sample > *vertex)
        return {*sample, positionOf(pair.a, sampler.point(sample - first, row.samples))};
    return {*vertex, pair.a.positions[vertices[vertex - distances.begin()]].cast<double>()};
}

}  // namespace

DistanceSamples measureDistance(const Surface& a, const Surface& b,
                                const std::vector<PartPair>& pairs,
                                const DistanceSettings& settings) {
    double total = 0;
    for (const PartPair& pair : pairs) total += Sampler(a, trianglesWithArea(a, pair.a)).area();
    DistanceSamples out;
    for (const PartPair& parts : pairs) {
        const std::vector<std::uint32_t> triangles = trianglesWithArea(a, parts.a);
        const Sampler sampler(a, triangles);
        const TriangleTree tree(b, withoutCopies(b, trianglesWithArea(b, parts.b)),
                                settings.tolerance);
        const Pair pair{a, b, tree};
        const double share = static_cast<double>(settings.samples) * sampler.area() / total;
        out.rows.push_back({.partA = parts.a,
                            .firstSample = out.distances.size(),
                            .samples = std::max<std::size_t>(1, std::llround(share))});
        measureSamples(pair, sampler, settings, out);
        out.rows.back().farthest =
            findFarthest(a, triangles, b, tree,
                         farthestKnown(pair, sampler, verticesOf(a, triangles), settings, out),
                         {.zero = settings.zero,
                          .searches = kSearchesPerSample * out.rows.back().samples,
                          .threads = settings.threads});
    }
    return out;
}

}  // namespace rivage::client
