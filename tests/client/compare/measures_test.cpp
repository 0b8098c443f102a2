#include "client/compare/measures.h"

#include <doctest/doctest.h>

#include "glb_builder.h"

using namespace rivage::client;
using namespace rivage::client::test;
using Eigen::Vector3d;

namespace {

Measures measured(const Shape& shape) {
    const Surface surface = surfaceOf({shape});
    return measure(surface, 0, surface.triangles.size());
}

/// Each triangle with vertices of its own, as a file with sharp edges has them.
Shape split(const Shape& shape) {
    Shape out;
    for (const auto& triangle : shape.triangles) {
        const auto first = static_cast<std::uint32_t>(out.positions.size());
        for (const std::uint32_t v : triangle) out.positions.push_back(shape.positions[v]);
        out.triangles.push_back({first, first + 1, first + 2});
    }
    return out;
}

}  // namespace

TEST_SUITE("client/compare") {
    TEST_CASE("measure: a cube of side 2") {
        const Measures cubes = measured(cube(1, 3));
        CHECK(cubes.area == doctest::Approx(24));
        REQUIRE(cubes.volume);
        CHECK(*cubes.volume == doctest::Approx(8));
        CHECK(cubes.low == Vector3d(1, 1, 1));
        CHECK(cubes.high == Vector3d(3, 3, 3));
        CHECK(cubes.flat == 0);
        CHECK(*measured(turned(cube(1, 3))).volume == doctest::Approx(-8));
    }

    TEST_CASE("measure: vertices at the same position are one") {
        REQUIRE(measured(split(cube(0, 1))).volume);
        CHECK(*measured(split(cube(0, 1))).volume == doctest::Approx(1));
    }

    TEST_CASE("measure: a surface with a hole, or with one face turned, encloses nothing") {
        Shape open = cube(0, 1);
        open.triangles.pop_back();
        CHECK_FALSE(measured(open).volume);
        Shape odd = cube(0, 1);
        std::swap(odd.triangles[3][0], odd.triangles[3][1]);
        CHECK_FALSE(measured(odd).volume);
        CHECK_FALSE(measured(plane(1, 2, 0)).volume);
    }

    TEST_CASE("measure: a ball has the area and volume of a ball, nearly") {
        const Measures balls = measured(ball({5, 6, 7}, 2, 60));
        CHECK(balls.area == doctest::Approx(4 * 3.14159265 * 4).epsilon(0.002));
        REQUIRE(balls.volume);
        CHECK(*balls.volume == doctest::Approx(4.0 / 3 * 3.14159265 * 8).epsilon(0.004));
        CHECK(balls.flat == 240);  // at the poles
    }

    TEST_CASE("measure: triangles without an area are counted and nothing else") {
        Shape shape = cube(0, 1);
        shape.triangles.push_back({0, 0, 1});
        shape.triangles.push_back({2, 2, 2});
        CHECK(measured(shape).flat == 2);
        CHECK(*measured(shape).volume == doctest::Approx(1));
    }
}
