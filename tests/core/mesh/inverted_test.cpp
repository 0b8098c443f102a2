#include "core/mesh/inverted.h"

#include <doctest/doctest.h>

#include <limits>

#include "tests/core/mesh/mesh_fixtures.h"

using namespace rivage::test;

TEST_SUITE_BEGIN("core/mesh");

TEST_CASE("invertedFaces: none on the lattice, whatever the labels") {
    for (std::uint32_t seed = 1; seed <= 5; ++seed) {
        const DigitalSurface surface = *extractSurface(randomGrid(seed, {5, 5, 5}, 3), {});
        CHECK(invertedFaces(surface, latticePositions(surface)).empty());
    }
}

TEST_CASE("invertedFaces: a folded, a collapsed and a non-finite face") {
    const DigitalSurface surface = *extractSurface(ballGrid(1, 2), {});
    const SurfelId face{0};
    const auto& corners = surface.corners[face];
    const auto touches = [&](const Positions& positions) {
        const auto found = invertedFaces(surface, positions);
        return std::count(found.begin(), found.end(), face) == 1;
    };
    Positions folded = latticePositions(surface);
    folded[corners[0]] = 2 * folded[corners[2]] - folded[corners[0]];
    CHECK(touches(folded));
    Positions thin = latticePositions(surface);
    thin[corners[0]] += 0.99 * (thin[corners[3]] - thin[corners[0]]);
    thin[corners[1]] += 0.99 * (thin[corners[2]] - thin[corners[1]]);
    CHECK(touches(thin));
    Positions notANumber = latticePositions(surface);
    notANumber[corners[1]].x() = std::numeric_limits<double>::quiet_NaN();
    CHECK(touches(notANumber));
}

TEST_CASE("property: untangle leaves no inverted face and moves on segments only") {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        CAPTURE(seed);
        const DigitalSurface surface = *extractSurface(randomGrid(seed, {6, 6, 6}, 2), {});
        const Positions before = movedPositions(surface, seed < 6 ? 0.49 : 3, seed);
        const std::size_t bad = invertedFaces(surface, before).size();
        REQUIRE(bad > 0);
        Positions after = before;
        CHECK(untangle(surface, after, {}).inverted == bad);
        CHECK(invertedFaces(surface, after).empty());
        for (std::uint32_t i = 0; i < after.size(); ++i) {
            const Vec3d rest = surface.pointels[PointelId{i}].cast<double>();
            const Vec3d full = before[PointelId{i}] - rest;
            const Vec3d kept = after[PointelId{i}] - rest;
            const double share = kept.norm() / full.norm();
            CHECK(share <= 1);
            CHECK((kept - share * full).norm() < 1e-9);
        }
    }
}

TEST_CASE("untangle: what is not near an inverted face stays where it is") {
    const DigitalSurface surface = *extractSurface(ballGrid(12, 5), {});
    Positions positions = movedPositions(surface, 0.05);
    const Positions before = positions;
    const auto& corners = surface.corners[SurfelId{7}];
    positions[corners[0]] = before[corners[2]];
    CHECK(untangle(surface, positions, {}).inverted >= 1);
    std::size_t moved = 0;
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        moved += positions[PointelId{i}] != before[PointelId{i}] ? 1 : 0;
    // The corner that was folded in, and two beside it; others were drawn back, and let go again.
    CHECK(moved <= 3);
    CHECK(positions[corners[0]] != before[corners[0]]);
}

TEST_CASE("untangle: draws back no further than it must") {
    double kept = 0;
    double all = 0;
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        const DigitalSurface surface = *extractSurface(randomGrid(seed, {6, 6, 6}, 2), {});
        const Positions before = movedPositions(surface, 0.49, seed);
        Positions after = before;
        untangle(surface, after, {});
        for (std::uint32_t i = 0; i < after.size(); ++i) {
            const Vec3d rest = surface.pointels[PointelId{i}].cast<double>();
            kept += (after[PointelId{i}] - rest).norm();
            all += (before[PointelId{i}] - rest).norm();
        }
    }
    CHECK(kept / all > 0.88);  // without letting go: 0.80
}

TEST_CASE("untangle: positions that are not finite go home") {
    const DigitalSurface surface = *extractSurface(ballGrid(4, 2), {});
    Positions positions = latticePositions(surface);
    positions[PointelId{3}].y() = std::numeric_limits<double>::infinity();
    positions[PointelId{4}].z() = std::numeric_limits<double>::quiet_NaN();
    CHECK(untangle(surface, positions, {}).inverted > 0);
    CHECK(positions == latticePositions(surface));
}

TEST_CASE("determinism: untangle with threads 1, 2, 7") {
    const DigitalSurface surface = splitSurface(randomGrid(3, {20, 20, 20}, 3));
    Positions one = movedPositions(surface, 0.49);
    Positions two = one;
    Positions seven = one;
    const Tangles found = untangle(surface, one, {.threads = 1});
    CHECK(found.crossing > 100);
    for (const auto& [threads, positions] : {std::pair{2, &two}, std::pair{7, &seven}}) {
        const Tangles other = untangle(surface, *positions, {.threads = threads});
        CHECK(other.inverted == found.inverted);
        CHECK(other.crossing == found.crossing);
    }
    CHECK(one == two);
    CHECK(one == seven);
}

TEST_SUITE_END();
