#include <doctest/doctest.h>

#include <limits>

#include "core/voxelize/revoxelize.h"
#include "tests/core/voxelize/voxelize_fixtures.h"

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

    TEST_CASE("property: so they do with an open border and voxels that are no cubes") {
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

    TEST_CASE("materials: that of the voxel around a sample, else that of the nearest face") {
        // Two materials of one label, side by side.
        VoxelGrid grid = makeGrid({12, 6, 6}, 2, [](const Vec3i& v) { return v.x() < 6 ? 1 : 2; });
        grid.materials[MaterialId{2}].label = Label{1};
        grid.labels.resize(2);
        const Sampled model = moved(std::move(grid), 0.3);
        const VoxelGrid fine = model.resampled(4);
        const SampleLattice lattice = SampleLattice::over({12, 6, 6}, 4, 1);
        std::size_t outside = 0;
        fine.voxels.forEach([&](const Vec3i& v, MaterialId m) {
            const MaterialId held = model.grid.voxels.at(lattice.voxelOf(v));
            if (held != MaterialId{0}) REQUIRE(m == held);
            outside += held == MaterialId{0};
            // Far from the border between them there is only one to choose.
            if (v.x() < 20) REQUIRE(m == MaterialId{1});
            if (v.x() >= 28) REQUIRE(m == MaterialId{2});
        });
        CHECK(outside == 0);  // the grid is cropped, so nothing is sampled outside it
    }

    TEST_CASE("nearest: as by looking at every face") {
        const Sampled model = moved(sectorGrid(14, 5), 0.45);
        std::mt19937 random(5);
        for (int i = 0; i < 300; ++i) {
            const auto unit = [&] { return static_cast<double>(random()) / 4294967295.0; };
            const Vec3d at = Vec3d(unit(), unit(), unit()) * 20 - Vec3d::Constant(3);
            const Label label{static_cast<std::uint16_t>(random() % 4)};
            double best = std::numeric_limits<double>::infinity();
            for (std::uint32_t s = 0; s < model.surface->surfelCount(); ++s) {
                const LabelPair labels = model.moved->labels(SurfelId{s});
                if (labels.inner == label || labels.outer == label)
                    best = std::min(best, (model.moved->centre(SurfelId{s}) - at).squaredNorm());
            }
            CHECK(model.nearest->find(at, label).squaredDistance == best);
        }
        CHECK(model.nearest->find(Vec3d::Zero(), Label{9}).surfel == kNone<SurfelId>);
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same voxels") {
        const Sampled model = moved(sectorGrid(24, 10), 0.49);
        const VoxelGrid one = model.resampled(5, 2, 1);
        for (const int threads : {2, 7})
            CHECK(sameVoxels(one.voxels, model.resampled(5, 2, threads).voxels));
    }

    TEST_CASE("reject: voxels and memory above the limits, and positions that are no numbers") {
        const Sampled model = moved(ballGrid(20, 9), 0.3);
        const LabelColumns columns = model.scan(4);
        RunContext run;
        run.limits.maxVoxels = 1000;
        auto fine = resample(model.grid, *model.nearest, columns, run);
        REQUIRE_FALSE(fine);
        CHECK(fine.error().code == ErrorCode::tooLarge);
        CHECK(fine.error().field == "/options/scale");
        CHECK(fine.error().actual > 1000);
        run = {};
        run.limits.maxMemory = 100'000;
        fine = resample(model.grid, *model.nearest, columns, run);
        REQUIRE_FALSE(fine);
        CHECK(fine.error().code == ErrorCode::memoryBudget);

        Positions broken = *model.positions;
        broken[PointelId{3}].y() = std::numeric_limits<double>::quiet_NaN();
        const auto snapped = snapSurface(*model.surface, broken, {});
        REQUIRE_FALSE(snapped);
        CHECK(snapped.error().code == ErrorCode::internal);
    }

    TEST_CASE("revoxelize: stands at the origin times the scale, rounded down") {
        const Sampled model = moved(ballGrid(6, 2.5), 0.2);
        VoxelGrid grid = model.grid;
        grid.origin = Vec3i(-3, 4, -1);
        VoxelReport report;
        for (const auto& [scale, origin] : {std::pair(Scale{3, 1}, Vec3i(-9, 12, -3)),
                                            {Scale{1, 2}, Vec3i(-2, 2, -1)},
                                            {Scale{3, 2}, Vec3i(-5, 6, -2)}}) {
            const auto made = revoxelize(grid, *model.surface, *model.positions, scale, {}, report);
            REQUIRE(made);
            CHECK(made->origin == origin);
        }
        CHECK(report.dims == std::array<int, 3>{9, 9, 9});
    }
}
