#include "core/emboss/refine.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "core/mesh/closed.h"
#include "tests/support/grids.h"
#include "tests/support/regularized.h"

using namespace rivage::test;

namespace {

RefinedSurface refined(const Regularized& made, const PointelVectors& positions, int detail,
                       int threads = 1) {
    return *refineSurface(made.surface, made.links, positions, detail, {.threads = threads});
}

PointelVectors latticeOf(const DigitalSurface& surface) {
    PointelVectors positions;
    for (std::uint32_t i = 0; i < surface.pointelCount(); ++i)
        positions.push_back(surface.position(PointelId{i}));
    return positions;
}

Regularized linked(const VoxelGrid& grid, bool split) {
    MethodOptions options;
    options.energy.split = split;
    return linkedSurface(grid, options);
}

/// Each voxel as detail^3 voxels.
VoxelGrid finer(const VoxelGrid& grid, int detail) {
    const int labels = static_cast<int>(grid.labels.size()) - 1;
    return makeGrid(detail * grid.voxels.size(), labels, [&](const Vec3i& v) {
        return static_cast<int>(index(grid.labelAt(v / detail)));
    });
}

using Corners = std::array<PointelId, 4>;

/// What a face is linked to, by corners: those of its own come first.
std::map<Corners, std::array<Corners, 4>> linksByCorners(const DigitalSurface& surface,
                                                         const SurfelLinks& links) {
    std::map<Corners, std::array<Corners, 4>> all;
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
        auto& across = all[surface.corners[SurfelId{i}]];
        for (std::size_t k = 0; k < 4; ++k)
            if (const SurfelId other = links[SurfelId{i}][k]; other != kNone<SurfelId>)
                across[k] = surface.corners[other];
    }
    return all;
}

}  // namespace

TEST_SUITE_BEGIN("core/emboss");

TEST_CASE("refineSurface: one piece a surfel is the surface itself") {
    for (std::uint32_t seed = 1; seed <= 6; ++seed)
        for (const bool split : {false, true}) {
            CAPTURE(seed);
            const VoxelGrid grid = randomGrid(seed, {5, 4, 6}, 1 + static_cast<int>(seed % 3));
            const Regularized made = linked(grid, split);
            const RefinedSurface same = refined(made, latticeOf(made.surface), 1);
            CHECK(same.surface.pointels == made.surface.pointels);
            CHECK(same.surface.neighbours == made.surface.neighbours);
            CHECK(same.surface.junctionSlots == made.surface.junctionSlots);
            CHECK(same.surface.corners == made.surface.corners);
            CHECK(same.surface.byInterface == made.surface.byInterface);
            CHECK(same.links == made.links);
            CHECK(same.rest == latticeOf(made.surface));
        }
}

TEST_CASE("differential: refineSurface gives the digital surface of the finer grid") {
    for (std::uint32_t seed = 1; seed <= 6; ++seed)
        for (const int detail : {2, 3}) {
            CAPTURE(seed);
            CAPTURE(detail);
            const VoxelGrid grid = randomGrid(seed, {4, 5, 4}, 1 + static_cast<int>(seed % 3));
            const Regularized made = linked(grid, false);
            const RefinedSurface pieces = refined(made, latticeOf(made.surface), detail);
            const Regularized expected = linked(finer(grid, detail), false);
            CHECK(pieces.surface.pointels == expected.surface.pointels);
            CHECK(pieces.surface.neighbours == expected.surface.neighbours);
            CHECK(pieces.surface.junctionSlots == expected.surface.junctionSlots);
            CHECK(linksByCorners(pieces.surface, pieces.links) ==
                  linksByCorners(expected.surface, expected.links));
            for (std::uint32_t i = 0; i < pieces.surface.pointelCount(); ++i)
                CHECK((pieces.rest[PointelId{i}] - pieces.surface.position(PointelId{i}))
                          .isZero(1e-12));
        }
}

TEST_CASE("refineSurface: an open border stays fixed, as on the finer grid") {
    VoxelGrid grid = randomGrid(4, {4, 1, 5}, 2);
    grid.openBorder = true;
    VoxelGrid fine = finer(grid, 3);
    fine.openBorder = true;
    const Regularized made = linked(grid, false);
    const RefinedSurface pieces = refined(made, latticeOf(made.surface), 3);
    const Regularized expected = linked(fine, false);
    CHECK(pieces.surface.pointels == expected.surface.pointels);
    CHECK(pieces.surface.fixedAxes == expected.surface.fixedAxes);
}

TEST_CASE("refineSurface: the pieces of a split surface are closed, their neighbours mutual") {
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        CAPTURE(seed);
        const VoxelGrid grid = randomGrid(seed, {6, 5, 5}, 1 + static_cast<int>(seed % 4));
        const Regularized made = linked(grid, true);
        const RefinedSurface pieces = refined(made, latticeOf(made.surface), 3);
        const std::vector<Closure> all(grid.labels.size() - 1, Closure::closed);
        CHECK(labelClosures(grid, pieces.surface) == all);
        std::size_t wrong = 0;
        for (std::uint32_t i = 0; i < pieces.surface.pointelCount(); ++i)
            for (int slot = 0; slot < kSlots; ++slot) {
                const PointelId next = pieces.surface.neighbours[PointelId{i}][slot];
                if (next == kNone<PointelId>) continue;
                wrong += pieces.surface.neighbours[next][slot ^ 1] != PointelId{i};
            }
        CHECK(wrong == 0);
    }
}

TEST_CASE("refineSurface: pointels lie bilinearly between the moved corners") {
    const VoxelGrid grid = ballGrid(6, 2.5);
    const Regularized made = regularize(grid, {});
    const RefinedSurface pieces = refined(made, made.positions, 4);
    for (std::uint32_t i = 0; i < made.surface.surfelCount(); ++i) {
        const auto& c = made.surface.corners[SurfelId{i}];
        const SurfelId middle{16 * i + 5};  // its third corner is (2, 2) of 4
        const Vec3d mean = (made.positions[c[0]] + made.positions[c[1]] + made.positions[c[2]] +
                            made.positions[c[3]]) /
                           4;
        CHECK((pieces.rest[pieces.surface.corners[middle][2]] - mean).isZero(1e-14));
        CHECK(pieces.parent(middle) == SurfelId{i});
    }
}

TEST_CASE("determinism: refineSurface gives the same bits for any number of threads") {
    const VoxelGrid grid = sectorGrid(14, 5.5);
    const Regularized made = regularize(grid, {});
    const RefinedSurface one = refined(made, made.positions, 3, 1);
    for (const int threads : {2, 7}) {
        const RefinedSurface other = refined(made, made.positions, 3, threads);
        CHECK(other.surface.pointels == one.surface.pointels);
        CHECK(other.surface.neighbours == one.surface.neighbours);
        CHECK(other.surface.corners == one.surface.corners);
        CHECK(other.links == one.links);
        CHECK(other.rest == one.rest);
    }
}

TEST_SUITE_END();
