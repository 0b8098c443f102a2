#include "core/mesh/shading.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

constexpr std::size_t kBlock = 4096;
constexpr double kVanishing = 1e-9;  // voxel^2: below it a direction is rounding noise

template <typename Body>
void forEachIndex(std::size_t count, const Workers& workers, const Body& body) {
    parallelBlocks(count, kBlock, workers, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) body(i);
    });
}

Vec3d faceNormal(const DigitalSurface& surface, SurfelId s, const Vec3d& area) {
    const double norm = area.norm();
    return norm > kVanishing ? Vec3d(area / norm) : surface.trivialNormal(s).cast<double>();
}

// The angle between two edge vectors, 0 where one of them vanishes.
double angleBetween(const Vec3d& a, const Vec3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Sums of the trivial normals of the groups: integers, so never a matter of rounding.
std::vector<Vec3i> trivialSums(const Patch& patch, const DigitalSurface& surface,
                               const CornerGroups& groups, const Workers& workers) {
    std::vector<Vec3i> sums(groups.count, Vec3i::Zero());
    serialFor(patch.cornerCount(), workers, [&](std::size_t c) {
        Vec3i& sum = sums[groups.of[c]];
        sum += surface.trivialNormal(patch.surfelOf(c));
        // Where they cancel, the first face decides.
        if (sum.isZero()) sum = surface.trivialNormal(patch.surfelOf(c));
    });
    return sums;
}

}  // namespace

std::vector<Vec3d> vectorAreas(const Patch& patch, const DigitalSurface& surface,
                               const IdVector<PointelId, Vec3d>& positions,
                               const Workers& workers) {
    std::vector<Vec3d> areas(patch.faceCount());
    forEachIndex(patch.faceCount(), workers, [&](std::size_t face) {
        const auto& corners = surface.corners[patch.surfels[face]];
        const Vec3d diagonal = positions[corners[2]] - positions[corners[0]];
        areas[face] = 0.5 * diagonal.cross(positions[corners[3]] - positions[corners[1]]);
    });
    return areas;
}

std::vector<std::uint8_t> smoothEdges(const Patch& patch, const DigitalSurface& surface,
                                      const std::vector<Vec3d>& areas, const Workers& workers) {
    const double limit = std::cos(kCreaseDegrees * std::numbers::pi / 180);
    std::vector<std::uint8_t> smooth(patch.cornerCount());
    forEachIndex(patch.cornerCount(), workers, [&](std::size_t edge) {
        const std::uint32_t other = patch.across[edge];
        if (other == kNoEdge) return;
        const Vec3d here = faceNormal(surface, patch.surfelOf(edge), areas[edge / 4]);
        const Vec3d there = faceNormal(surface, patch.surfelOf(other), areas[other / 4]);
        smooth[edge] = here.dot(there) >= limit ? 1 : 0;
    });
    return smooth;
}

std::vector<Vec3f> groupNormals(const Patch& patch, const DigitalSurface& surface,
                                const IdVector<PointelId, Vec3d>& positions,
                                const std::vector<Vec3d>& areas, const CornerGroups& groups,
                                const Workers& workers) {
    std::vector<double> angles(patch.cornerCount());
    forEachIndex(patch.cornerCount(), workers, [&](std::size_t i) {
        const auto c = static_cast<std::uint32_t>(i);
        const Vec3d& at = positions[patch.pointelOf(surface, c)];
        angles[c] = angleBetween(positions[patch.pointelOf(surface, nextCorner(c))] - at,
                                 positions[patch.pointelOf(surface, previousCorner(c))] - at);
    });
    // One thread adds, in the order of the corners.
    std::vector<Vec3d> sums(groups.count, Vec3d::Zero());
    serialFor(patch.cornerCount(), workers,
              [&](std::size_t c) { sums[groups.of[c]] += angles[c] * areas[c / 4]; });

    const std::vector<Vec3i> fallback = trivialSums(patch, surface, groups, workers);
    std::vector<Vec3f> normals(groups.count);
    forEachIndex(groups.count, workers, [&](std::size_t g) {
        const double norm = sums[g].norm();
        const bool usable = norm > kVanishing && std::isfinite(norm);
        const Vec3d sum = usable ? sums[g] : fallback[g].cast<double>();
        normals[g] = sum.normalized().cast<float>();
    });
    return normals;
}

}  // namespace rivage::core
