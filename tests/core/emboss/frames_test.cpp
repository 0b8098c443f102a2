#include "core/emboss/frames.h"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>

using namespace rivage::core;

TEST_SUITE_BEGIN("core/emboss");

TEST_CASE("tileFrame: up on walls is +z, right is as seen from outside") {
    const Vec3d sides[4] = {Vec3d::UnitX(), Vec3d::UnitY(), -Vec3d::UnitX(), -Vec3d::UnitY()};
    for (const Vec3d& normal : sides) {
        const TileFrame frame = tileFrame(normal);
        CHECK((frame.v - Vec3d::UnitZ()).isZero(1e-12));
        CHECK((frame.u - Vec3d::UnitZ().cross(normal)).isZero(1e-12));
    }
    const TileFrame floor = tileFrame(Vec3d::UnitZ());
    CHECK(floor.u == Vec3d::UnitX());
    CHECK(floor.v == Vec3d::UnitY());
}

TEST_CASE("tileFrame: on roofs of 1:1 the frame is theirs exactly, v goes up the slope") {
    const Vec3d front = Vec3d(0, -1, 1).normalized();
    const TileFrame frame = tileFrame(front);
    CHECK((frame.u - Vec3d::UnitX()).isZero(1e-12));
    CHECK((frame.v - Vec3d(0, 1, 1).normalized()).isZero(1e-12));
    const TileFrame under = tileFrame(Vec3d(0, -1, -1).normalized());
    CHECK((under.v - Vec3d(0, -1, 1).normalized()).isZero(1e-12));
}

// A length on the surface, seen in the coordinates of the tile.
TEST_CASE("property: lengths are off by 9 percent at most, and 16 between two steps") {
    for (int a = 0; a < 72; ++a)
        for (int b = 0; b <= 36; ++b) {
            const double turn = 5 * a * M_PI / 180;
            const double slope = 5 * b * M_PI / 180;
            const Vec3d normal(std::sin(slope) * std::cos(turn), std::sin(slope) * std::sin(turn),
                               std::cos(slope));
            const TileFrame frame = tileFrame(normal);
            const Vec3d along = frame.u - frame.u.dot(normal) * normal;
            const Vec3d up = frame.v - frame.v.dot(normal) * normal;
            CHECK(along.norm() > 0.92);
            CHECK(up.norm() > 0.84);
            CHECK(frame.u.norm() == doctest::Approx(1));
            CHECK(frame.v.norm() == doctest::Approx(1));
            // Never mirrored.
            CHECK(frame.u.cross(frame.v).dot(normal) > (normal.z() < -0.9 ? -1.1 : 0.8));
        }
}

TEST_SUITE_END();
