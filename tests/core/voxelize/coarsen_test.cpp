#include <doctest/doctest.h>

#include "core/voxelize/coarsen.h"
#include "core/voxelize/revoxelize.h"
#include "core/voxelize/thin_parts.h"
#include "tests/core/voxelize/voxelize_fixtures.h"

using namespace rivage::test;

namespace {

struct Coarse {
    VoxelGrid grid;
    VoxelReport report;
};

Coarse coarser(const Sampled& model, const Scale& scale, int threads = 1) {
    Coarse made;
    made.grid = *revoxelize(model.grid, *model.surface, *model.positions, scale,
                            {.threads = threads}, made.report);
    return made;
}

VoxelGrid painted(VoxelGrid grid, const std::vector<Rgba8>& colors) {
    for (std::size_t m = 1; m < grid.materials.size(); ++m) {
        grid.materials.raw()[m].color = colors[m - 1];
        grid.materials.raw()[m].label = Label{1};
    }
    grid.labels.resize(2);
    return grid;
}

}  // namespace

TEST_SUITE("core/voxelize") {
    TEST_CASE("coarsen: what is aligned with the coarser voxels stays as it is") {
        const Vec3i size(8, 12, 4);
        const VoxelGrid blocks = makeGrid(size, 3, [](const Vec3i& v) {
            return (v.x() / 2 + v.y() / 2 * 3 + v.z() / 2 * 5) % 4;
        });
        const Coarse made = coarser(moved(blocks, 0), {1, 2});
        CHECK(made.report.samplesEach == 64);
        for (int z = 0; z < 2; ++z)
            for (int y = 0; y < 6; ++y)
                for (int x = 0; x < 4; ++x)
                    CHECK(made.grid.voxels.at({x, y, z}) == blocks.voxels.at(2 * Vec3i(x, y, z)));
    }

    TEST_CASE("coarsen: sizes round up, and every scale below 1 has samples enough") {
        for (const Scale scale :
             {Scale{1, 2}, Scale{1, 3}, Scale{2, 3}, Scale{1, 16}, Scale{15, 16}, Scale{3, 16}}) {
            const Vec3i size = scaledSize({40, 33, 17}, scale);
            const SampleLattice lattice = samplesFor(size, scale);
            CHECK(lattice.size.x() % size.x() == 0);
            CHECK(lattice.size.x() / size.x() >= 4);
            CHECK(lattice.up >= 2 * lattice.down);
            // As many samples for a voxel of the result as its side has times their rate.
            CHECK(lattice.up * scale.down == lattice.size.x() / size.x() * lattice.down * scale.up);
        }
        CHECK(scaledSize({40, 33, 17}, {1, 2}) == Vec3i(20, 17, 9));
    }

    TEST_CASE("coarsen: a solid label wins a tie, so a wall of half a voxel stays") {
        const VoxelGrid wall = makeGrid({1, 12, 12}, 1, [](const Vec3i&) { return 1; });
        const Coarse made = coarser(moved(wall, 0), {1, 2});
        CHECK(made.grid.voxels.countVoxels() == 36);
        CHECK(made.report.topology.at(0).before.components == 1);
        CHECK(made.report.topology.at(0).after.components == 1);
    }

    TEST_CASE("coarsen: a side that ends in the middle of a voxel fills it") {
        const Coarse made =
            coarser(moved(makeGrid({3, 4, 4}, 1, [](const Vec3i&) { return 1; }), 0), {1, 2});
        CHECK(made.grid.voxels.countVoxels() == 8);
        CHECK(made.report.rescued == 0);
    }

    TEST_CASE("coarsen: a lone wall of a third of a voxel comes back whole") {
        const VoxelGrid wall = makeGrid({12, 12, 12}, 2, [](const Vec3i& v) {
            return v.x() == 4 ? 1 : v.x() > 8 ? 2 : 0;
        });
        const Coarse made = coarser(moved(wall, 0), {1, 3});
        CHECK(made.report.rescued == 16);
        CHECK(made.report.topology.at(0).after.components == 1);
        for (int z = 0; z < 4; ++z)
            for (int y = 0; y < 4; ++y) {
                CHECK(made.grid.labelAt({1, y, z}) == Label{1});
                CHECK(made.grid.labelAt({0, y, z}) == Label{0});
                CHECK(made.grid.labelAt({3, y, z}) == Label{2});
            }
    }

    TEST_CASE("coarsen: a wall that stands off comes back, a layer that lies on does not") {
        // A floor of 3 voxels, a wall one voxel thick on it, and a layer of one voxel beside it.
        const VoxelGrid house = makeGrid({18, 9, 15}, 1, [](const Vec3i& v) {
            return v.z() < 3 || v.x() == 4 || (v.x() > 8 && v.z() < 4);
        });
        const Coarse made = coarser(moved(house, 0), {1, 3});
        for (int y = 0; y < 3; ++y) {
            for (int z = 1; z < 5; ++z) CHECK(made.grid.labelAt({1, y, z}) == Label{1});
            for (int x = 3; x < 6; ++x) CHECK(made.grid.labelAt({x, y, 1}) == Label{0});
        }
    }

    TEST_CASE("thin parts: they do not take the last voxel of another label") {
        VoxelGrid grid =
            makeGrid({3, 3, 3}, 2, [](const Vec3i& v) { return v == Vec3i(1, 1, 1) ? 2 : 0; });
        const std::vector<MaterialId> stand{MaterialId{0}, MaterialId{1}, MaterialId{2}};
        const std::vector<VotedVoxel> candidates{{{1, 1, 1}, Label{1}}, {{2, 2, 2}, Label{1}}};
        CHECK(keepThinParts(grid, candidates, stand, {}) == 1);
        CHECK(grid.labelAt({1, 1, 1}) == Label{2});
        CHECK(grid.labelAt({2, 2, 2}) == Label{1});
    }

    TEST_CASE("colours: near ones count together, and what is seen counts before what is not") {
        // Two reds of 3 and 2 columns in 9, and 4 columns of blue.
        const VoxelGrid shades =
            painted(makeGrid({3, 3, 3}, 3,
                             [](const Vec3i& v) {
                                 const int column = v.x() + 3 * v.y();
                                 return column < 3 ? 1 : column < 5 ? 2 : 3;
                             }),
                    {{200, 20, 20, 255}, {205, 22, 20, 255}, {20, 20, 200, 255}});
        const Coarse reds = coarser(moved(shades, 0), {1, 3});
        REQUIRE(reds.grid.voxels.size() == Vec3i(1, 1, 1));
        CHECK(reds.grid.voxels.at({0, 0, 0}) == MaterialId{1});

        const VoxelGrid shell = painted(makeGrid({8, 8, 8}, 2,
                                                 [](const Vec3i& v) {
                                                     const Vec3i w =
                                                         (v * 2 - Vec3i::Constant(7)).cwiseAbs();
                                                     return w.maxCoeff() == 7 ? 1 : 2;
                                                 }),
                                        {{10, 200, 10, 255}, {90, 90, 90, 255}});
        const Coarse seen = coarser(moved(shell, 0), {1, 4});
        seen.grid.voxels.forEach([](const Vec3i&, MaterialId m) { CHECK(m == MaterialId{1}); });
        CHECK(seen.grid.voxels.countVoxels() == 8);

        // A roof one voxel thick on a wall: the wall has more voxels, the roof more that is seen.
        const VoxelGrid roof =
            painted(makeGrid({12, 12, 4}, 2, [](const Vec3i& v) { return v.z() == 3 ? 1 : 2; }),
                    {{200, 30, 20, 255}, {240, 230, 200, 255}});
        const Coarse tiled = coarser(moved(roof, 0), {1, 4});
        CHECK(tiled.grid.voxels.at({1, 1, 0}) == MaterialId{1});
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same voxels") {
        const Sampled model = moved(sectorGrid(30, 13), 0.49);
        const Coarse one = coarser(model, {2, 3}, 1);
        for (const int threads : {2, 7})
            CHECK(sameVoxels(one.grid.voxels, coarser(model, {2, 3}, threads).grid.voxels));
    }
}
