#include "core/grid/brick_grid.h"

#include <doctest/doctest.h>

#include <map>
#include <random>
#include <tuple>
#include <vector>

using namespace rivage::core;

TEST_SUITE_BEGIN("core/grid");

TEST_CASE("differential: a brick grid holds what a map of voxels holds") {
    for (const unsigned seed : {1U, 2U, 3U}) {
        CAPTURE(seed);
        std::mt19937 random(seed);
        const Vec3i size(17, 33, 40);
        BrickGrid grid(size);
        std::map<std::tuple<int, int, int>, MaterialId> expected;
        for (int i = 0; i < 500; ++i) {
            const Vec3i v(static_cast<int>(random() % 17), static_cast<int>(random() % 33),
                          static_cast<int>(random() % 40));
            const MaterialId material{static_cast<std::uint16_t>(random() % 4)};
            grid.set(v, material);
            expected[{v.z(), v.y(), v.x()}] = material;
        }
        std::uint64_t filled = 0;
        for (const auto& [at, material] : expected) {
            const auto [z, y, x] = at;
            CHECK(grid.at(Vec3i(x, y, z)) == material);
            filled += material != MaterialId{0};
        }
        CHECK(grid.countVoxels() == filled);
        grid.forEach([&](const Vec3i& v, MaterialId material) {
            CHECK(expected.at({v.z(), v.y(), v.x()}) == material);
            --filled;
        });
        CHECK(filled == 0);
    }
}

TEST_CASE("brick grid: outside is empty, and empty voxels take no brick") {
    BrickGrid grid(Vec3i(20, 20, 20));
    grid.set(Vec3i(19, 19, 19), MaterialId{0});
    CHECK(grid.brick(Vec3i(1, 1, 1)) == nullptr);
    grid.set(Vec3i(19, 19, 19), MaterialId{3});
    CHECK(grid.brick(Vec3i(1, 1, 1)) != nullptr);
    CHECK(grid.brick(Vec3i(0, 0, 0)) == nullptr);
    CHECK(grid.brick(Vec3i(2, 0, 0)) == nullptr);
    CHECK(grid.at(Vec3i(20, 19, 19)) == MaterialId{0});
    CHECK(grid.at(Vec3i(-1, 0, 0)) == MaterialId{0});
    CHECK(grid.memoryBytes() >= sizeof(BrickGrid::Brick));
    CHECK(BrickGrid().countVoxels() == 0);
}

TEST_CASE("brick grid: rows run over bricks and over both ends") {
    BrickGrid grid(Vec3i(40, 2, 2));
    grid.set(Vec3i(0, 1, 1), MaterialId{1});
    grid.set(Vec3i(15, 1, 1), MaterialId{2});
    grid.set(Vec3i(39, 1, 1), MaterialId{3});
    std::vector<MaterialId> row(44, MaterialId{9});
    CHECK(grid.copyRow(-2, 1, 1, row));
    for (std::size_t i = 0; i < row.size(); ++i)
        CHECK(row[i] == MaterialId{static_cast<std::uint16_t>(i == 2    ? 1
                                                              : i == 17 ? 2
                                                              : i == 41 ? 3
                                                                        : 0)});
    CHECK_FALSE(grid.copyRow(0, 2, 1, row));
    CHECK(row[0] == MaterialId{0});
}

TEST_CASE("brick grid: remap renames every stored voxel") {
    BrickGrid grid(Vec3i(3, 1, 1));
    grid.set(Vec3i(0, 0, 0), MaterialId{1});
    grid.set(Vec3i(1, 0, 0), MaterialId{2});
    const std::vector<MaterialId> map{MaterialId{0}, MaterialId{5}, MaterialId{0}};
    grid.remap(map);
    CHECK(grid.at(Vec3i(0, 0, 0)) == MaterialId{5});
    CHECK(grid.countVoxels() == 1);
}

TEST_SUITE_END();
