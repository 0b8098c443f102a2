#include "tests/study/bodies.h"

#include <doctest/doctest.h>

#include "tests/support/random.h"

using namespace rivage::study;
using namespace rivage::test;

TEST_SUITE_BEGIN("study");

namespace {

Vec3d randomPoint(std::mt19937& random, double reach) {
    return reach *
           Vec3d(2 * unitDraw(random) - 1, 2 * unitDraw(random) - 1, 2 * unitDraw(random) - 1);
}

/// Whether the surface of a solid passes within about `reach`: feet are not asked for beyond
/// centres of curvature.
bool isNear(const Body& solid, const Vec3d& p, double reach) {
    for (int k = 0; k < 27; ++k) {
        const Vec3d way = Vec3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        if (solid.labelAt(p + reach * way) != solid.labelAt(p)) return true;
    }
    return false;
}

LabelPair inside(int label) { return {static_cast<Label>(label), Label{0}}; }

}  // namespace

TEST_CASE("property: the foot lies on the surface, as far away as it says") {
    std::mt19937 random(5);
    for (const Body& one : bodies()) {
        if (one.labels != 1) continue;
        CAPTURE(one.name);
        for (int k = 0; k < 400; ++k) {
            const Vec3d p = randomPoint(random, 0.5);
            if (!isNear(one, p, 0.05)) continue;
            const Foot foot = one.foot(inside(1), p);
            CAPTURE(p.transpose());
            CHECK((foot.distance <= 0) == (one.labelAt(p) == 1));
            CHECK((p - foot.at).norm() == doctest::Approx(std::abs(foot.distance)).epsilon(1e-6));
            CHECK(std::abs(one.foot(inside(1), foot.at).distance) < 1e-6);
            CHECK(foot.normal.norm() == doctest::Approx(1));
        }
    }
}

// A shorter way to the surface than the one to the foot would show up among random directions.
TEST_CASE("differential: no sampled point of the surface is nearer than the foot") {
    std::mt19937 random(6);
    for (const Body& one : bodies()) {
        if (one.labels != 1) continue;
        CAPTURE(one.name);
        for (int k = 0; k < 200; ++k) {
            const Vec3d p = randomPoint(random, 0.45);
            if (!isNear(one, p, 0.02)) continue;
            const double distance = std::abs(one.foot(inside(1), p).distance);
            const int label = one.labelAt(p);
            for (int i = 0; i < 300; ++i) {
                const Vec3d way = randomPoint(random, 1).normalized() * distance * 0.99;
                CHECK(one.labelAt(p + way) == label);
            }
        }
    }
}

TEST_CASE("property: labels change where the foot of their interface says") {
    std::mt19937 random(7);
    for (const Body& one : bodies()) {
        CAPTURE(one.name);
        for (int k = 0; k < 3000; ++k) {
            const Vec3d p = randomPoint(random, 0.45);
            const Vec3d q = p + randomPoint(random, 0.01);
            const int a = one.labelAt(p);
            const int b = one.labelAt(q);
            if (a == b) continue;
            const bool aIsInner = b == 0 || (a != 0 && a < b);
            const LabelPair pair{static_cast<Label>(aIsInner ? a : b),
                                 static_cast<Label>(aIsInner ? b : a)};
            const Foot foot = one.foot(pair, p);
            CAPTURE(p.transpose());
            // Inside the inner label or not, and no farther than the step that left it.
            if (foot.edge > 0.03) CHECK((foot.distance <= 0) == aIsInner);
            CHECK(std::abs(foot.distance) <= (p - q).norm() + 1e-9);
        }
    }
}

TEST_CASE("property: every shape fits its grid in every pose") {
    for (const Body& one : bodies())
        for (std::uint32_t number = 0; number < 8; ++number) {
            CAPTURE(one.name);
            const Shape shape = digitize(one, 16, pose(number));
            std::vector<bool> seen(static_cast<std::size_t>(one.labels) + 1, false);
            shape.grid.voxels.forEach([&](const Vec3i& v, MaterialId) {
                seen[index(shape.grid.labelAt(v))] = true;
                // A shape that was cut off would show many voxels on the border.
                CHECK((v.cast<double>() - Vec3d::Constant(7.5)).norm() < 0.44 * 16 + 1);
            });
            for (int label = 1; label <= one.labels; ++label)
                if (one.name != "house") CHECK(seen[label]);
        }
}

TEST_CASE("fandisk: distances to its creases") {
    constexpr double kUnit = 0.44 / 5.6;
    const Body& one = body("fandisk");
    const Vec3d besideCorner = kUnit * Vec3d(4, -3.5, 0);
    CHECK(one.foot(inside(1), besideCorner).edge == doctest::Approx(0.5 * kUnit));
    const Vec3d onFlat = kUnit * Vec3d(0, -3, 0.5);
    CHECK(one.foot(inside(1), onFlat).edge == doctest::Approx(2 * kUnit));
    CHECK(std::abs(one.foot(inside(1), onFlat).distance) < 1e-12);
    const Vec3d onArc = kUnit * (Vec3d(-2, 1, 0) + Vec3d(-std::sqrt(2), std::sqrt(2), 0));
    CHECK(std::abs(one.foot(inside(1), onArc).distance) < 1e-12);
    const Vec3d inHollow = kUnit * (Vec3d(4, 1, 0) - Vec3d(std::sqrt(2), std::sqrt(2), 0));
    CHECK(std::abs(one.foot(inside(1), inHollow).distance) < 1e-12);
}

TEST_SUITE_END();
