#include "core/mesh/closed.h"

#include <doctest/doctest.h>

#include "tests/core/mesh/mesh_fixtures.h"

using namespace rivage::test;

TEST_SUITE_BEGIN("core/mesh");

TEST_CASE("labelClosures: every label of a complete surface is closed, split or not") {
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        const VoxelGrid grid = randomGrid(seed, {5, 6, 4}, 1 + static_cast<int>(seed % 4));
        const std::vector<Closure> all(grid.labels.size() - 1, Closure::closed);
        CHECK(labelClosures(grid, *extractSurface(grid, {})) == all);
        CHECK(labelClosures(grid, splitSurface(grid)) == all);
    }
}

TEST_CASE("labelClosures: a face with a wrong label opens that label and no other") {
    const VoxelGrid grid = makeGrid({9, 1, 1}, 3, [](const Vec3i& v) {
        return v.x() % 4 == 0 ? v.x() / 4 + 1 : 0;  // three separate voxels
    });
    DigitalSurface surface = *extractSurface(grid, {});
    SurfelId ofSecond{0};
    while (index(surface.interfaceOf[ofSecond]) != 1) ofSecond = SurfelId{index(ofSecond) + 1};
    surface.interfaceOf[ofSecond] = InterfaceId{2};
    CHECK(labelClosures(grid, surface) ==
          std::vector<Closure>{Closure::closed, Closure::open, Closure::open});
}

TEST_CASE("labelClosures: a face at a copy of its own is noticed") {
    const VoxelGrid grid = ballGrid(4, 2);
    DigitalSurface surface = *extractSurface(grid, {});
    const PointelId copy = surface.pointels.push_back(surface.pointels[PointelId{0}]);
    surface.corners[SurfelId{0}][0] = copy;
    CHECK(labelClosures(grid, surface) == std::vector<Closure>{Closure::open});
}

TEST_SUITE_END();
