#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "tests/support/grids.h"
#include "tests/support/intersections.h"
#include "tests/support/regularized.h"
#include "tests/support/walls.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

Sides regularizedWall(const Vec3i& direction, bool split) {
    const Vec3d normal = direction.cast<double>().normalized();
    Regularized wall{.surface = *extractSurface(wallGrid(direction), {})};
    const SurfelLinks links = *linkSurfels(wall.surface, {});
    // The border is to be free here, so that what it holds back does not reach into the middle.
    wall.surface.fixedAxes = {};
    if (split) CHECK(*splitUmbrellas(wall.surface, links, {}) > 100);
    const MethodOptions options;
    const Energy energy(wall.surface, NormalField(wall.surface.surfelCount(), normal),
                        EnergyWeights::uniform(wall.surface, options.energy), options.energy, 1);
    wall.positions = minimize(energy, {.tolerance = 1e-5}, {})->positions;
    const Tangles tangles = untangle(wall.surface, wall.positions, {});
    CHECK(tangles.crossing == 0);
    CHECK(countIntersections(wall.surface, wall.positions) == 0);
    return measureSides(wall, direction);
}

}  // namespace

TEST_SUITE("core/pipeline") {
    TEST_CASE("split: a diagonal wall one voxel thick keeps its thickness and its normal") {
        for (const Vec3i& normal : {Vec3i(1, 1, 0), Vec3i(1, 1, 1), Vec3i(2, 1, 0), Vec3i(1, 2, 3),
                                    Vec3i(3, 3, 1), Vec3i(3, 2, 2)}) {
            const std::string name = std::to_string(normal.x()) + " " + std::to_string(normal.y()) +
                                     " " + std::to_string(normal.z());
            CAPTURE(name);
            const double ideal = idealThickness(normal);
            const Sides with = regularizedWall(normal, true);
            const Sides without = regularizedWall(normal, false);
            CHECK(std::abs(with.thickness - ideal) < 0.02 * ideal);
            CHECK(with.roughness < 0.01);
            CHECK(with.normalError < 0.5);
            CHECK(without.thickness < 0.3 * ideal);
        }
    }
}
