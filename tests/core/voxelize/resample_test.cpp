#include <doctest/doctest.h>

#include "tests/core/voxelize/voxelize_fixtures.h"
#include "tests/support/regularized.h"

using namespace rivage::test;

TEST_SUITE("core/voxelize") {
    TEST_CASE("property: odd factors give the input back, however vertices move below 0.5") {
        for (std::uint32_t seed = 1; seed <= 12; ++seed) {
            CAPTURE(seed);
            const Sampled model = moved(randomGrid(seed, {9, 7, 8}, 4), 0.49, seed);
            for (const int factor : {1, 3, 5}) {
                CAPTURE(factor);
                CHECK(sameVoxels(decimated(model.resampled(factor).voxels, factor),
                                 model.grid.voxels));
            }
        }
    }

    TEST_CASE("property: an open border, anisotropic voxels: odd factors give the input back") {
        for (std::uint32_t seed = 1; seed <= 12; ++seed) {
            CAPTURE(seed);
            VoxelGrid grid = randomGrid(seed, {6, 5, 7}, 3);
            grid.openBorder = true;
            grid.spacing = Vec3d(1, 2.5, 1.25);
            const Sampled model = moved(std::move(grid), 0.49, seed);
            for (const int factor : {1, 3})
                CHECK(sameVoxels(decimated(model.resampled(factor).voxels, factor),
                                 model.grid.voxels));
        }
    }
}
