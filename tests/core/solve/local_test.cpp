#include "core/solve/local.h"

#include <doctest/doctest.h>

#include "tests/core/solve/prepared.h"

using namespace rivage::core;
using namespace rivage::test;

TEST_SUITE("core/solve") {
    TEST_CASE("local: after an edit the part around it is enough") {
        // A long bar, so that most of it is far from the edit.
        const PreparedSurface prepared(makeGrid({220, 9, 9}, 1,
                                                [](const Vec3i& v) {
                                                    const Vec3i off = v - Vec3i(v.x(), 4, 4);
                                                    return off.squaredNorm() <= 17 ? 1 : 0;
                                                }),
                                       {.alpha = 0.05}, [](DigitalSurface&) {});
        for (const std::optional<double> limit : {std::optional<double>(), std::optional(0.3)}) {
            const SolveOptions options{.displacementLimit = limit, .tolerance = 1e-8};
            const auto before = minimize(prepared.energy(), options, {});
            REQUIRE(before);

            NormalField normals = prepared.normals;
            EnergyWeights weights = EnergyWeights::uniform(prepared.surface, prepared.options);
            std::vector<PointelId> changed;
            for (std::uint32_t f = 0; f < prepared.surface.surfelCount(); ++f) {
                const auto& corners = prepared.surface.corners[SurfelId{f}];
                if (std::abs(prepared.surface.pointels[corners[0]].x() - 30) > 2) continue;
                normals[SurfelId{f}] = (normals[SurfelId{f}] + Vec3d(0.7, 0, 0)).normalized();
                weights.beta[SurfelId{f}] = 0.8;
                changed.insert(changed.end(), corners.begin(), corners.end());
            }
            const Energy edited(prepared.surface, normals, weights, prepared.options, 1);
            const auto full = minimize(edited, options, {});
            const auto local = reminimizeAround(edited, before->positions, changed, options, {});
            REQUIRE(full);
            REQUIRE(local);
            CHECK(local->converged);
            CHECK(largestDifference(before->positions, full->positions) > 0.05);
            CHECK(largestDifference(local->positions, full->positions) < 1e-3);
            CHECK(local->touched > changed.size() / 4);
            CHECK(local->touched < prepared.surface.pointelCount() / 2);
            CHECK(local->rimResidual < 2e-3);
            CHECK(local->rimResidual > 0);
        }
    }
}
