#include "tests/support/accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/mesh/diagonal.h"
#include "tests/support/random.h"

namespace rivage::test {

namespace {

double degrees(const Vec3d& a, const Vec3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }

const LabelPair& labelsOf(const DigitalSurface& surface, SurfelId s) {
    return surface.interfaces[surface.interfaceOf[s]].labels;
}

/// Whether each surfel is in a part of at least `least` surfels that hang together by links.
std::vector<bool> inLargeParts(const Regularized& result, std::size_t least) {
    std::vector<bool> large(result.surface.surfelCount(), false);
    std::vector<bool> seen = large;
    std::vector<SurfelId> part;
    for (std::size_t i = 0; i < large.size(); ++i) {
        if (seen[i]) continue;
        part.assign(1, surfel(i));
        seen[i] = true;
        for (std::size_t next = 0; next < part.size(); ++next)
            for (const SurfelId other : result.links[part[next]]) {
                if (other == kNone<SurfelId> || seen[index(other)]) continue;
                seen[index(other)] = true;
                part.push_back(other);
            }
        if (part.size() < least) continue;
        for (const SurfelId s : part) large[index(s)] = true;
    }
    return large;
}

double meanOf(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// What the faces around a vertex say about it.
struct VertexDistance {
    double farthest = 0;  ///< signed
    bool used = false;
    bool measured = true;  ///< by all of its faces
};

void measureVertices(const Shape& shape, const Regularized& result, const std::vector<bool>& large,
                     PositionErrors& errors) {
    IdVector<PointelId, VertexDistance> vertices(result.surface.pointelCount(), VertexDistance{});
    for (std::size_t i = 0; i < result.surface.surfelCount(); ++i) {
        const LabelPair& labels = labelsOf(result.surface, surfel(i));
        for (const PointelId p : result.surface.corners[surfel(i)]) {
            VertexDistance& vertex = vertices[p];
            const Vec3d& x = result.positions[p];
            vertex.used = true;
            vertex.measured = vertex.measured && large[i] && shape.measured(labels, x);
            if (!vertex.measured) continue;
            const double distance = shape.distance(labels, x);
            if (std::abs(distance) > std::abs(vertex.farthest)) vertex.farthest = distance;
        }
    }
    double count = 0;
    for (const VertexDistance& vertex : vertices) {
        if (!vertex.used || !vertex.measured) continue;
        ++count;
        errors.rms += vertex.farthest * vertex.farthest;
        errors.bias += vertex.farthest;
        errors.max = std::max(errors.max, std::abs(vertex.farthest));
    }
    errors.rms = std::sqrt(errors.rms / count);
    errors.bias /= count;
}

void measureFaces(const Shape& shape, const Regularized& result, const std::vector<bool>& large,
                  PositionErrors& errors) {
    double count = 0;
    double areas = 0;
    for (std::size_t i = 0; i < result.surface.surfelCount(); ++i) {
        const auto& c = result.surface.corners[surfel(i)];
        const PointelVectors& x = result.positions;
        const LabelPair& labels = labelsOf(result.surface, surfel(i));
        const Vec3d centroid = 0.25 * (x[c[0]] + x[c[1]] + x[c[2]] + x[c[3]]);
        if (!large[i] || !shape.measured(labels, centroid)) continue;
        const Vec3d across = 0.5 * (x[c[2]] - x[c[0]]).cross(x[c[3]] - x[c[1]]);
        const double error = degrees(across, shape.normal(labels, centroid));
        ++count;
        areas += across.norm();
        errors.normalMean += across.norm() * error;
        errors.normalRms += error * error;
    }
    errors.normalMean /= areas;
    errors.normalRms = std::sqrt(errors.normalRms / count);
}

/// Six times the volume between the origin and a face.
double coneVolume6(const Regularized& result, SurfelId s) {
    const auto& corners = result.surface.corners[s];
    const std::uint32_t k = firstCorner(corners, result.positions);
    const auto at = [&](std::uint32_t corner) -> const Vec3d& {
        return result.positions[corners[(k + corner) % 4]];
    };
    return at(0).dot(at(1).cross(at(2))) + at(0).dot(at(2).cross(at(3)));
}

}  // namespace

NormalErrors normalErrors(const Shape& shape, const Regularized& result, std::size_t leastPart) {
    const std::vector<bool> large = inLargeParts(result, leastPart);
    std::vector<double> all;
    std::vector<double> near;
    for (std::size_t i = 0; i < result.surface.surfelCount(); ++i) {
        const LabelPair& labels = labelsOf(result.surface, surfel(i));
        const Vec3d centre = result.surface.centre(surfel(i));
        const double edge = shape.edge(labels, centre);
        if (!large[i] || !shape.measured(labels, centre) || edge < 1) continue;
        const double error = degrees(result.normals[surfel(i)], shape.normal(labels, centre));
        all.push_back(error);
        if (edge <= 3) near.push_back(error);
    }
    if (all.empty()) return {};
    const auto rank = static_cast<std::size_t>(0.95 * static_cast<double>(all.size() - 1));
    NormalErrors errors{.mean = meanOf(all), .nearEdges = meanOf(near)};
    std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(rank), all.end());
    errors.percentile95 = all[rank];
    return errors;
}

PositionErrors positionErrors(const Shape& shape, const Regularized& result,
                              std::size_t leastPart) {
    const std::vector<bool> large = inLargeParts(result, leastPart);
    PositionErrors errors;
    measureVertices(shape, result, large, errors);
    measureFaces(shape, result, large, errors);
    return errors;
}

NormalField tilted(const NormalField& normals, double sigma, std::uint32_t seed) {
    std::mt19937 random(seed);
    NormalField result = normals;
    for (Vec3d& normal : result) {
        const Vec3d u = normal.unitOrthogonal();
        const double angle = gaussian(random) * sigma * M_PI / 180;
        const double turn = 2 * M_PI * unitDraw(random);
        const Vec3d tangent = std::cos(turn) * u + std::sin(turn) * normal.cross(u);
        normal = std::cos(angle) * normal + std::sin(angle) * tangent;
    }
    return result;
}

double volumeErrorPercent(const VoxelGrid& grid, const Regularized& result) {
    std::vector<double> missing(grid.labels.size(), 0);
    double total = 0;
    grid.voxels.forEach([&](const Vec3i& voxel, MaterialId) {
        const Label label = grid.labelAt(voxel);
        if (label == Label{0}) return;
        ++missing[index(label)];
        ++total;
    });
    for (std::size_t i = 0; i < result.surface.surfelCount(); ++i) {
        const double volume = coneVolume6(result, surfel(i)) / 6;
        const LabelPair& labels = labelsOf(result.surface, surfel(i));
        missing[index(labels.inner)] -= volume;
        missing[index(labels.outer)] += volume;
    }
    double sum = 0;
    for (std::size_t label = 1; label < missing.size(); ++label) sum += std::abs(missing[label]);
    return 100 * sum / total;
}

std::size_t countOpenEdges(const DigitalSurface& surface) {
    std::vector<std::array<std::uint32_t, 3>> sides;  // label and both ends, once a face
    for (std::size_t i = 0; i < surface.surfelCount(); ++i) {
        const auto& corners = surface.corners[surfel(i)];
        const LabelPair& labels = labelsOf(surface, surfel(i));
        for (std::size_t k = 0; k < 4; ++k)
            for (const Label label : {labels.inner, labels.outer}) {
                if (label == Label{0}) continue;
                const auto ends = std::minmax(corners[k], corners[(k + 1) % 4]);
                sides.push_back({index(label), index(ends.first), index(ends.second)});
            }
    }
    std::sort(sides.begin(), sides.end());
    std::size_t open = 0;
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && sides[end] == sides[begin]) ++end;
        open += (end - begin) % 2;
    }
    return open;
}

std::size_t countOrphans(const DigitalSurface& surface) {
    IdVector<PointelId, char> used(surface.pointelCount(), 0);
    for (const auto& corners : surface.corners)
        for (const PointelId p : corners) used[p] = 1;
    return static_cast<std::size_t>(std::count(used.begin(), used.end(), 0));
}

double largestDisplacement(const Regularized& result, const Vec3i& size, int least) {
    double largest = 0;
    for (std::size_t i = 0; i < result.positions.size(); ++i) {
        const Vec3i& at = result.surface.pointels.raw()[i];
        int planes = 0;
        for (int axis = 0; axis < 3; ++axis) planes += at[axis] == 0 || at[axis] == size[axis];
        if (planes < least) continue;
        const PointelId p{static_cast<std::uint32_t>(i)};
        largest = std::max(largest, (result.positions[p] - result.surface.position(p)).norm());
    }
    return largest;
}

}  // namespace rivage::test
