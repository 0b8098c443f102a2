#include "core/energy/weights.h"

#include <doctest/doctest.h>

#include "core/surface/split_umbrellas.h"
#include "tests/support/grids.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

/// Two regions side by side: label 1 at x < 2, label 2 behind.
VoxelGrid pairGrid() {
    return makeGrid({4, 3, 2}, 2, [](const Vec3i& v) { return v.x() < 2 ? 1 : 2; });
}

EnergyWeights weightsOf(const VoxelGrid& grid, const std::vector<RegionWeights>& regions) {
    EnergyOptions options;
    options.regions = regions;
    return *weightsByRegion(*extractSurface(grid, {}), grid.labels, options);
}

}  // namespace

TEST_SUITE("core/energy") {
    TEST_CASE("weights: without regions they are the same everywhere") {
        const VoxelGrid grid = pairGrid();
        const DigitalSurface surface = *extractSurface(grid, {});
        const EnergyWeights weights = weightsOf(grid, {});
        const EnergyWeights uniform = EnergyWeights::uniform(surface, {});
        CHECK(weights.alpha == uniform.alpha);
        CHECK(weights.beta == uniform.beta);
        CHECK(weights.gamma == uniform.gamma);
    }

    TEST_CASE("weights: faces take their region's factors, those between two the mean") {
        const VoxelGrid grid = pairGrid();
        const DigitalSurface surface = *extractSurface(grid, {});
        const EnergyWeights weights = weightsOf(
            grid, {{.region = "label 1", .alpha = 10, .beta = 3}, {.region = "*", .gamma = 2}});
        const EnergyOptions normal;
        for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
            const LabelPair labels = surface.interfaces[surface.interfaceOf[SurfelId{i}]].labels;
            const double expected = labels.outer != Label{0} ? 2 : labels.inner == Label{1} ? 3 : 1;
            CHECK(weights.beta[SurfelId{i}] == doctest::Approx(normal.beta * expected));
        }
        for (std::uint32_t i = 0; i < surface.pointelCount(); ++i) {
            const Vec3i& at = surface.pointels[PointelId{i}];
            if (at.x() == 2) continue;
            const bool first = at.x() < 2;
            CHECK(weights.alpha[PointelId{i}] == doctest::Approx(normal.alpha * (first ? 10 : 1)));
            CHECK(weights.gamma[PointelId{i}] == doctest::Approx(normal.gamma * (first ? 1 : 2)));
        }
        // A corner of the wall between them: one face of each side twice, and one between.
        for (std::uint32_t i = 0; i < surface.pointelCount(); ++i)
            if (surface.pointels[PointelId{i}] == Vec3i(2, 0, 0))
                CHECK(weights.alpha[PointelId{i}] ==
                      doctest::Approx(normal.alpha * (10 + 10 + 1 + 1 + 5.5) / 5));
    }

    TEST_CASE("weights: a large alpha holds its region and lets the other go") {
        const VoxelGrid grid = sectorGrid(16, 6.5, 2);
        const EnergyWeights weights = weightsOf(grid, {{.region = "label 2", .alpha = 1000}});
        const DigitalSurface surface = *extractSurface(grid, {});
        double low = 1e9;
        double high = 0;
        for (const double alpha : weights.alpha) {
            low = std::min(low, alpha);
            high = std::max(high, alpha);
        }
        CHECK(low == doctest::Approx(0.01));
        CHECK(high == doctest::Approx(10));
    }

    TEST_CASE("reject: a region that the grid does not have, with those that it has") {
        const VoxelGrid grid = pairGrid();
        const auto weights = weightsByRegion(*extractSurface(grid, {}), grid.labels,
                                             {.regions = {{.region = "sea", .alpha = 2}}});
        REQUIRE_FALSE(weights);
        CHECK(weights.error().code == ErrorCode::invalidOption);
        CHECK(weights.error().field == "/options/weights/sea");
        CHECK(weights.error().message.ends_with("it has label 1, label 2"));
    }

    TEST_CASE("operator: symmetric on split surfaces, ends of slits included") {
        for (const int labels : {1, 2}) {
            const VoxelGrid grid = randomGrid(11, {7, 8, 6}, labels);
            DigitalSurface surface = *extractSurface(grid, {});
            const SurfelLinks links = *linkSurfels(surface, {});
            CHECK(*splitUmbrellas(surface, links, {}) > 5);
            const EnergyOptions options{.gamma = 3, .fairness = Fairness::umbrella};
            NormalField normals(surface.surfelCount());
            for (std::uint32_t i = 0; i < normals.size(); ++i)
                normals[SurfelId{i}] = surface.trivialNormal(SurfelId{i}).cast<double>();
            const Energy energy(surface, normals, EnergyWeights::uniform(surface, options), options,
                                1);
            std::mt19937 random(5);
            std::uniform_real_distribution<double> unit(-1, 1);
            std::array<PointelVectors, 2> x;
            std::array<PointelVectors, 2> product;
            Energy::Scratch scratch;
            for (int k = 0; k < 2; ++k) {
                x[k].resize(surface.pointelCount());
                for (Vec3d& v : x[k]) v = Vec3d(unit(random), unit(random), unit(random));
                energy.apply(x[k], product[k], scratch);
            }
            double forth = 0;
            double back = 0;
            for (std::uint32_t i = 0; i < surface.pointelCount(); ++i) {
                forth += x[0][PointelId{i}].dot(product[1][PointelId{i}]);
                back += x[1][PointelId{i}].dot(product[0][PointelId{i}]);
            }
            CHECK(forth == doctest::Approx(back).epsilon(1e-10));
        }
    }
}
