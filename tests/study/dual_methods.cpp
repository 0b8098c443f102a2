#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "tests/study/peers.h"
#include "tests/support/random.h"

namespace rivage::study {
namespace {

/// The normal equations of the planes around a vertex.
struct Quadric {
    Mat3d matrix = Mat3d::Zero();
    Vec3d right = Vec3d::Zero();
};

PointelVectors meansOf(const DigitalSurface& surface, const Crossings& crossings) {
    PointelVectors means(surface.pointelCount(), Vec3d::Zero());
    IdVector<PointelId, double> counts(surface.pointelCount());
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i)
        for (const PointelId p : surface.corners[SurfelId{i}]) {
            means[p] += crossings[SurfelId{i}];
            ++counts[p];
        }
    for (std::uint32_t i = 0; i < means.size(); ++i)
        means[PointelId{i}] /= std::max(counts[PointelId{i}], 1.0);
    return means;
}

/// Offset from the mean of the crossings.
Vec3d solveTruncated(const Quadric& quadric, const Vec3d& mean) {
    constexpr double kCut = 0.1;  // of the largest singular value
    const Eigen::SelfAdjointEigenSolver<Mat3d> solver(quadric.matrix);
    const Vec3d values = solver.eigenvalues();  // squares of the singular values
    const Vec3d right = quadric.right - quadric.matrix * mean;
    Vec3d offset = Vec3d::Zero();
    for (int k = 0; k < 3; ++k) {
        if (values[k] <= kCut * kCut * values[2]) continue;
        const Vec3d axis = solver.eigenvectors().col(k);
        offset += axis.dot(right) / values[k] * axis;
    }
    return offset;
}

/// A hair less than half a voxel: on the border of its cell a vertex would touch planes of voxel
/// centres, and it would mean nothing on which side they are.
Vec3d inCell(const DigitalSurface& surface, PointelId p, const Vec3d& x) {
    const Vec3d rest = surface.position(p);
    const Vec3d half = Vec3d::Constant(0.5 - 1e-6);
    return x.cwiseMax(rest - half).cwiseMin(rest + half);
}

Vec3d neighbourMean(const DigitalSurface& surface, const PointelVectors& x, PointelId p) {
    const unsigned junction = surface.junctionSlots[p];
    Vec3d sum = Vec3d::Zero();
    int count = 0;
    for (int slot = 0; slot < kSlots; ++slot) {
        const PointelId other = surface.neighbours[p][slot];
        if (other == kNone<PointelId> || (junction != 0 && (junction >> slot & 1) == 0)) continue;
        sum += x[other];
        ++count;
    }
    return count == 0 ? x[p] : Vec3d(sum / count);
}

}  // namespace

Crossings crossings(const DigitalSurface& surface, double noise, std::uint32_t seed) {
    std::mt19937 random(seed);
    Crossings result(surface.surfelCount(), Vec3d::Zero());
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
        const SurfelId s{i};
        const double along = noise * (2 * test::unitDraw(random) - 1);
        result[s] = surface.centre(s) + along * surface.trivialNormal(s).cast<double>();
    }
    return result;
}

PointelVectors dualContouring(const DigitalSurface& surface, const Crossings& crossings,
                              const NormalField& normals, bool clamped) {
    IdVector<PointelId, Quadric> quadrics(surface.pointelCount(), Quadric{});
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
        const SurfelId s{i};
        const Vec3d& normal = normals[s];
        for (const PointelId p : surface.corners[s]) {
            Quadric& quadric = quadrics[p];
            quadric.matrix += normal * normal.transpose();
            quadric.right += normal.dot(crossings[s]) * normal;
        }
    }
    PointelVectors positions = meansOf(surface, crossings);
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        const PointelId p{i};
        positions[p] += solveTruncated(quadrics[p], positions[p]);
        if (clamped) positions[p] = inCell(surface, p, positions[p]);
    }
    return positions;
}

PointelVectors surfaceNets(const DigitalSurface& surface, const Crossings& crossings,
                           int iterations) {
    PointelVectors positions = meansOf(surface, crossings);
    for (int k = 0; k < iterations; ++k) {
        PointelVectors next = positions;
        for (std::uint32_t i = 0; i < next.size(); ++i) {
            const PointelId p{i};
            const Vec3d middle = 0.5 * (positions[p] + neighbourMean(surface, positions, p));
            next[p] = inCell(surface, p, middle);
        }
        positions = std::move(next);
    }
    return positions;
}

}  // namespace rivage::study
