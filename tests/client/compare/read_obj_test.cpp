#include <doctest/doctest.h>

#include <random>

#include "client/compare/surface.h"

using namespace rivage::client;
using Eigen::Vector3f;

namespace {

const char* const kSample =
    "# Rivage 0.1.0, metres, y up\n"
    "o first\n"
    "g first opaque\n"
    "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\nv 0 1 0 0.5 0.5 0.5\n"
    "vn 0 0 1\n"
    "f 1//1 2//1 3//1 4//1\n"
    "o second\r\n"
    "usemtl glass\r\n"
    "v 0 0 1\r\nv 1 0 1\r\nv 1e0 +1 1.0\r\n"
    "f -3/1/1 -2/1/1 -1/1/1\r\n";

void refuse(const std::string& text, const char* why) {
    CAPTURE(text);
    const auto surface = readSurface(text);
    REQUIRE_FALSE(surface);
    CHECK(surface.error().exit == ExitCode::refused);
    const std::string detail = textOf(surface.error().problem, "detail");
    CAPTURE(detail);
    CHECK(detail.find(why) != std::string::npos);
}

}  // namespace

TEST_SUITE("client/compare") {
    TEST_CASE(
        "readSurface: an OBJ file with quads, colours, parts and every way to name a vertex") {
        const auto surface = readSurface(kSample);
        REQUIRE(surface);
        CHECK(surface->format == "obj");
        CHECK(surface->positions.size() == 7);
        REQUIRE(surface->triangles.size() == 3);
        CHECK(surface->triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
        CHECK(surface->triangles[1] == std::array<std::uint32_t, 3>{0, 2, 3});
        CHECK(surface->triangles[2] == std::array<std::uint32_t, 3>{4, 5, 6});
        REQUIRE(surface->parts.size() == 2);
        CHECK(surface->parts[0].name == "first");
        CHECK(surface->parts[0].count == 2);
        CHECK(surface->parts[1].name == "second");
        CHECK(surface->materials == 1);
        CHECK(surface->primitives == 1);
        CHECK(surface->colors[0] == Vector3f(1, 0, 0));
        CHECK(surface->colors[3].x() == doctest::Approx(0.21404));  // linear
        CHECK(surface->colors[6] == Vector3f(1, 1, 1));
        CHECK(surface->positions[6] == Vector3f(1, 1, 1));
    }

    TEST_CASE("readSurface: an OBJ file without colours or parts has none") {
        const auto surface = readSurface("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3");
        REQUIRE(surface);
        CHECK(surface->colors.empty());
        REQUIRE(surface->parts.size() == 1);
        CHECK(surface->parts[0].count == 1);
        CHECK(surface->parts[0].name.empty());
        CHECK(readSurface("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no last"));
    }

    TEST_CASE("reject: lines that are not what they should be") {
        const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        refuse(start + "f 1 2 4\n", "names no vertex");
        refuse(start + "f 1 2 0\n", "line 4");
        refuse(start + "f 1 2 -4\n", "names no vertex");
        refuse(start + "f 1 2 99999999999999999999\n", "names no vertex");
        refuse(start + "f 1 2 4294967297\n", "names no vertex");
        refuse(start + "f 1 2 x\n", "names no vertex");
        refuse(start + "f 1 2\n", "three corners");
        refuse("v 1 2\nf 1 1 1\n", "line 1");
        refuse("v 1 2 x\n", "three finite numbers");
        refuse("v 1 2 nan\n", "three finite numbers");
        refuse("v 1 2 1e99\n", "three finite numbers");
        refuse("v 1 2 3 4 5\n", "three numbers");
        refuse("v 1 2 3 4 5 6 7\n", "three finite numbers");
        refuse("hello", "no OBJ file");
        refuse("v 1 2 3\n", "no OBJ file");
    }

    TEST_CASE("reject: more triangles than the limit") {
        const std::string start = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 1 2 3\n";
        CHECK(readSurface(start, {.maxTriangles = 4}));
        CHECK_FALSE(readSurface(start, {.maxTriangles = 3}));
    }

    TEST_CASE("property: every prefix and every change is read or refused") {
        const std::string good = kSample;
        for (std::size_t size = 0; size < good.size(); ++size) {
            const auto surface = readSurface(good.substr(0, size));
            if (!surface) CHECK(surface.error().exit == ExitCode::refused);
        }
        std::mt19937 random(5);
        for (int i = 0; i < 20'000; ++i) {
            std::string bytes = good;
            bytes[random() % bytes.size()] = static_cast<char>(random());
            const auto surface = readSurface(bytes);
            if (!surface) continue;
            for (const auto& triangle : surface->triangles)
                for (const std::uint32_t v : triangle) REQUIRE(v < surface->positions.size());
        }
    }
}
