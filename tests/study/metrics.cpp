#include "tests/study/metrics.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/union_find.h"
#include "tests/support/intersections.h"
#include "tests/support/voxel_centres.h"

namespace rivage::study {
namespace {

constexpr double kLeastArea = 0.02;  // of a unit face, as `invertedFaces` has it

double degrees(const Vec3d& a, const Vec3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

Vec3d areaVector(const StudyMesh& mesh, const Face& face) {
    const auto& x = mesh.vertices;
    const auto& c = face.corners;
    if (face.isTriangle()) return 0.5 * (x[c[1]] - x[c[0]]).cross(x[c[2]] - x[c[0]]);
    return 0.5 * (x[c[2]] - x[c[0]]).cross(x[c[3]] - x[c[1]]);
}

Vec3d centroid(const StudyMesh& mesh, const Face& face) {
    const auto& x = mesh.vertices;
    const auto& c = face.corners;
    if (face.isTriangle()) return (x[c[0]] + x[c[1]] + x[c[2]]) / 3;
    return 0.25 * (x[c[0]] + x[c[1]] + x[c[2]] + x[c[3]]);
}

/// Whether each face is in a part of at least `least` faces that hang together by edges.
std::vector<bool> inLargeParts(const StudyMesh& mesh, std::size_t least) {
    std::vector<bool> large(mesh.faces.size(), true);
    if (least <= 1) return large;
    struct Edge {
        std::uint32_t a, b, face;
        auto operator<=>(const Edge&) const = default;
    };
    std::vector<Edge> edges;
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f)
        for (int k = 0; k < 4; ++k) {
            const auto ends =
                std::minmax(mesh.faces[f].corners[k], mesh.faces[f].corners[(k + 1) % 4]);
            if (ends.first != ends.second) edges.push_back({ends.first, ends.second, f});
        }
    std::sort(edges.begin(), edges.end());
    UnionFind parts(mesh.faces.size());
    for (std::size_t i = 1; i < edges.size(); ++i)
        if (edges[i].a == edges[i - 1].a && edges[i].b == edges[i - 1].b)
            parts.join(edges[i].face, edges[i - 1].face);
    std::vector<std::size_t> sizes(mesh.faces.size(), 0);
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) ++sizes[parts.find(f)];
    for (std::uint32_t f = 0; f < mesh.faces.size(); ++f) large[f] = sizes[parts.find(f)] >= least;
    return large;
}

class Weighted {
public:
    void add(double value, double weight) {
        sum_ += weight * value;
        weights_ += weight;
    }
    [[nodiscard]] double mean() const { return sum_ / weights_; }  // NaN without any

private:
    double sum_ = 0;
    double weights_ = 0;
};

struct VertexDistance {
    double farthest = 0;
    bool used = false;
};

void measureVertices(const Shape& shape, const StudyMesh& mesh, const std::vector<bool>& large,
                     Measures& m) {
    std::vector<VertexDistance> vertices(mesh.vertices.size());
    std::vector<std::pair<std::uint32_t, LabelPair>> pairs;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
        if (large[f])
            for (const std::uint32_t v : mesh.faces[f].corners)
                pairs.emplace_back(v, mesh.faces[f].labels);
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    for (const auto& [v, labels] : pairs) {
        const double distance = shape.distance(labels, mesh.vertices[v]);
        VertexDistance& vertex = vertices[v];
        vertex.used = true;
        if (std::abs(distance) > std::abs(vertex.farthest)) vertex.farthest = distance;
    }
    double count = 0;
    double sum = 0;
    double signedSum = 0;
    double squares = 0;
    double most = 0;
    for (const VertexDistance& vertex : vertices) {
        if (!vertex.used) continue;
        ++count;
        const double distance = std::abs(vertex.farthest);
        sum += distance;
        signedSum += vertex.farthest;
        squares += distance * distance;
        most = std::max(most, distance);
    }
    m[Measure::rms] = std::sqrt(squares / count);
    m[Measure::mean] = sum / count;
    m[Measure::bias] = signedSum / count;
    m[Measure::max] = most;
}

double weightedPercentile(std::vector<std::pair<double, double>> valuesAndWeights, double share) {
    std::sort(valuesAndWeights.begin(), valuesAndWeights.end());
    double total = 0;
    for (const auto& [value, weight] : valuesAndWeights) total += weight;
    double below = 0;
    for (const auto& [value, weight] : valuesAndWeights) {
        below += weight;
        if (below >= share * total) return value;
    }
    return std::numeric_limits<double>::quiet_NaN();
}

/// Corners of a face that point more than a right angle away from `normal`.
int invertedCorners(const StudyMesh& mesh, const Face& face, const Vec3d& normal) {
    const int sides = face.isTriangle() ? 3 : 4;
    int count = 0;
    for (int k = 0; k < sides; ++k) {
        const Vec3d& x = mesh.vertices[face.corners[k]];
        const Vec3d next = mesh.vertices[face.corners[(k + 1) % sides]] - x;
        const Vec3d last = mesh.vertices[face.corners[(k + sides - 1) % sides]] - x;
        count += next.cross(last).dot(normal) < 0;
    }
    return count;
}

void measureFaces(const Shape& shape, const StudyMesh& mesh, const std::vector<bool>& large,
                  Measures& m) {
    Weighted all;
    Weighted near;
    Weighted far;
    std::vector<std::pair<double, double>> errors;
    double inverted = 0;
    double corners = 0;
    double degenerate = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        if (!large[f]) continue;
        const Face& face = mesh.faces[f];
        const Vec3d area = areaVector(mesh, face);
        const Vec3d at = centroid(mesh, face);
        const Vec3d normal = shape.normal(face.labels, at);
        const double error = degrees(area, normal);
        const double edge = shape.edge(face.labels, at);
        all.add(error, area.norm());
        errors.emplace_back(error, area.norm());
        if (edge > 3) far.add(error, area.norm());
        if (edge >= 1 && edge <= 3) near.add(error, area.norm());
        inverted += invertedCorners(mesh, face, normal);
        corners += face.isTriangle() ? 3 : 4;
        degenerate += area.norm() < kLeastArea * (face.isTriangle() ? 0.5 : 1);
    }
    m[Measure::normalMean] = all.mean();
    m[Measure::normal95] = weightedPercentile(std::move(errors), 0.95);
    m[Measure::nearCrease] = near.mean();
    m[Measure::farCrease] = far.mean();
    m[Measure::inverted] = 100 * inverted / corners;
    m[Measure::degenerate] = 400 * degenerate / corners;
    m[Measure::faces] = static_cast<double>(mesh.faces.size());
}

double estimateError(const Shape& shape, const Outcome& outcome) {
    Weighted errors;
    const DigitalSurface& surface = outcome.surface;
    for (std::uint32_t i = 0; i < outcome.normals.size(); ++i) {
        const SurfelId s{i};
        const LabelPair& labels = surface.interfaces[surface.interfaceOf[s]].labels;
        const Vec3d centre = surface.centre(s);
        if (shape.edge(labels, centre) < 1) continue;  // either side is right
        errors.add(degrees(outcome.normals[s], shape.normal(labels, centre)), 1);
    }
    return errors.mean();
}

double volumeError(const Shape& shape, const StudyMesh& mesh) {
    std::vector<double> missing(shape.grid.labels.size(), 0);
    double total = 0;
    shape.grid.voxels.forEach([&](const Vec3i& voxel, MaterialId) {
        const Label label = shape.grid.labelAt(voxel);
        if (label == Label{0}) return;
        ++missing[index(label)];
        ++total;
    });
    for (const Face& face : mesh.faces)
        for (const auto& t : trianglesOf(mesh, face)) {
            const double volume = t[0].dot(t[1].cross(t[2])) / 6;
            missing[index(face.labels.inner)] -= volume;
            missing[index(face.labels.outer)] += volume;
        }
    double sum = 0;
    for (std::size_t label = 1; label < missing.size(); ++label) sum += std::abs(missing[label]);
    return 100 * sum / total;
}

/// Feet of the surfel centres on the true surface.
std::vector<Vec3d> trueSamples(const Shape& shape, const DigitalSurface& surface) {
    std::vector<Vec3d> points;
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
        const SurfelId s{i};
        const LabelPair& labels = surface.interfaces[surface.interfaceOf[s]].labels;
        const Vec3d centre = surface.centre(s);
        const Vec3d foot = centre - shape.distance(labels, centre) * shape.normal(labels, centre);
        // Beyond a crease that step does not lead to the surface; near it others do.
        if (std::abs(shape.distance(labels, foot)) < 1e-6) points.push_back(foot);
    }
    return points;
}

void measureThoroughly(const Shape& shape, const Outcome& outcome, const MeasureOptions& options,
                       Measures& m) {
    const bool isDual = !outcome.surface.corners.empty();
    if (options.clean != nullptr) {
        if (isDual)
            m[Measure::untrue] = static_cast<double>(
                test::countWrongCentres(*options.clean, outcome.surface, outcome.positions));
        return;
    }
    if (!isDual) return;
    m[Measure::crossing] =
        static_cast<double>(test::countIntersections(outcome.surface, outcome.positions));
    m[Measure::wrong] = static_cast<double>(
        test::countWrongCentres(shape.grid, outcome.surface, outcome.positions));
}

}  // namespace

Measures measure(const Shape& shape, const Outcome& outcome, const MeasureOptions& options) {
    Measures m;
    const std::vector<bool> large = inLargeParts(outcome.mesh, options.leastPart);
    measureVertices(shape, outcome.mesh, large, m);
    measureFaces(shape, outcome.mesh, large, m);
    if (!outcome.normals.empty()) m[Measure::estimate] = estimateError(shape, outcome);
    const bool sharedTwice = outcome.surface.corners.empty() && shape.grid.labels.size() > 2;
    if (!sharedTwice) m[Measure::volume] = volumeError(shape, outcome.mesh);
    if (options.bothWays) {
        const auto points = trueSamples(shape, *extractSurface(shape.grid, {}));
        m[Measure::hausdorff] = std::max(m[Measure::max], farthestFrom(outcome.mesh, points));
    }
    if (options.thorough) measureThoroughly(shape, outcome, options, m);
    return m;
}

}  // namespace rivage::study
