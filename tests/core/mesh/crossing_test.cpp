#include "core/mesh/crossing.h"

#include <doctest/doctest.h>

#include "core/mesh/inverted.h"
#include "tests/core/mesh/mesh_fixtures.h"
#include "tests/support/intersections.h"

using namespace rivage::test;

namespace {

/// Two voxels that share the corner (1, 1, 1).
DigitalSurface cornerTouch() {
    return splitSurface(makeGrid({2, 2, 2}, 1, [](const Vec3i& v) {
        return v == Vec3i(0, 0, 0) || v == Vec3i(1, 1, 1) ? 1 : 0;
    }));
}

/// The copies of the corner, each moved along the diagonal: positive is away from the own voxel.
Positions cornerMoved(const DigitalSurface& surface, double distance) {
    Positions positions = latticePositions(surface);
    for (std::uint32_t s = 0; s < surface.surfelCount(); ++s)
        for (const PointelId p : surface.corners[SurfelId{s}])
            if (surface.pointels[p] == Vec3i(1, 1, 1)) {
                const bool low = surface.innerVoxel(SurfelId{s}) == Vec3i(0, 0, 0);
                positions[p] = Vec3d::Constant(low ? 1 + distance : 1 - distance);
            }
    return positions;
}

/// Two in three grids have one label, where sheets touch most.
DigitalSurface noise(std::uint32_t seed) {
    return splitSurface(randomGrid(seed, {8, 9, 7}, seed % 3 == 0 ? 3 : 1));
}

}  // namespace

TEST_SUITE_BEGIN("core/mesh");

TEST_CASE("checker: triangles that pierce, overlap, touch or stay apart") {
    const Triangle flat = {Vec3d(0, 0, 0), Vec3d(2, 0, 0), Vec3d(0, 2, 0)};
    const auto with = [&](const Triangle& t) {
        CHECK(trianglesIntersect(flat, t) == trianglesIntersect(t, flat));
        return trianglesIntersect(flat, t);
    };
    CHECK(with({Vec3d(0.5, 0.5, -1), Vec3d(0.5, 0.5, 1), Vec3d(3, 3, 0)}));
    CHECK(with({Vec3d(0.2, 0.2, -1), Vec3d(0.6, 0.2, 1), Vec3d(0.2, 0.6, 1)}));
    CHECK(with({Vec3d(0.2, 0.2, 0), Vec3d(3, 0.2, 0), Vec3d(0.2, 3, 0)}));
    CHECK(with(flat));
    CHECK_FALSE(with({Vec3d(0.5, 0.5, 0), Vec3d(0.5, 0.5, 1), Vec3d(3, 3, 1)}));  // touches
    CHECK_FALSE(with({Vec3d(0, 0, 0), Vec3d(2, 0, 0), Vec3d(0, -2, 0)}));
    CHECK_FALSE(with({Vec3d(0, 0, 0), Vec3d(-2, 0, 0), Vec3d(0, -2, 0)}));
    CHECK_FALSE(with({Vec3d(0, 0, 0), Vec3d(2, 0, 0), Vec3d(0, 0, 2)}));
    CHECK_FALSE(with({Vec3d(3, 3, -1), Vec3d(3, 3, 1), Vec3d(5, 5, 0)}));
    CHECK_FALSE(with({Vec3d(0, 0, 0.1), Vec3d(2, 0, 0.1), Vec3d(0, 2, 0.1)}));
}

TEST_CASE("crossingFaces: corners that leave or enter each other") {
    const DigitalSurface surface = cornerTouch();
    CHECK(touchingFaces(surface).size() == 9);
    for (const double distance : {-0.3, -0.01, 0.0}) {
        CHECK(crossingFaces(surface, cornerMoved(surface, distance)).empty());
        CHECK(countIntersections(surface, cornerMoved(surface, distance)) == 0);
    }
    for (const double distance : {0.01, 0.3}) {
        CHECK(crossingFaces(surface, cornerMoved(surface, distance)).size() > 3);
        CHECK(countIntersections(surface, cornerMoved(surface, distance)) > 3);
    }
}

TEST_CASE("crossingFaces: none on the lattice, whatever the labels") {
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        const DigitalSurface surface = noise(seed);
        CHECK(touchingFaces(surface).size() > (seed % 3 == 0 ? 10 : 100));
        CHECK(crossingFaces(surface, latticePositions(surface)).empty());
        CHECK(countIntersections(surface, latticePositions(surface)) == 0);
    }
}

TEST_CASE("differential: below half a voxel, all that intersects is found") {
    std::size_t all = 0;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        CAPTURE(seed);
        const DigitalSurface surface = noise(seed);
        const Positions positions = movedPositions(surface, 0.49, seed);
        const std::size_t crossing = crossingFaces(surface, positions).size();
        all += crossing;
        CHECK(countIntersections(surface, positions) == crossing);
    }
    CHECK(all > 500);
}

TEST_CASE("property: untangle leaves no faces that intersect without a common vertex") {
    std::size_t all = 0;
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        CAPTURE(seed);
        const DigitalSurface surface = noise(seed);
        Positions positions = movedPositions(surface, 0.49, seed);
        all += untangle(surface, positions, {}).crossing;
        CHECK(invertedFaces(surface, positions).empty());
        CHECK(crossingFaces(surface, positions).empty());
        CHECK(countIntersections(surface, positions) == 0);
    }
    CHECK(all > 500);
}

TEST_CASE("property: the same with long voxels and an open border") {
    std::size_t all = 0;
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
        CAPTURE(seed);
        VoxelGrid grid = randomGrid(seed, {8, 9, 7}, 1);
        grid.spacing = Vec3d(1, 2, 5);
        grid.openBorder = seed % 2 == 0;
        const DigitalSurface surface = splitSurface(grid);
        Positions positions = movedPositions(surface, 0.49, seed);
        for (std::uint32_t i = 0; i < positions.size(); ++i) {
            const Vec3d rest = surface.position(PointelId{i});
            positions[PointelId{i}] =
                rest + (positions[PointelId{i}] - rest).cwiseProduct(grid.spacing);
        }
        CHECK(countIntersections(surface, positions) == crossingFaces(surface, positions).size());
        all += untangle(surface, positions, {}).crossing;
        CHECK(countIntersections(surface, positions) == 0);
    }
    CHECK(all > 300);
}

TEST_SUITE_END();
