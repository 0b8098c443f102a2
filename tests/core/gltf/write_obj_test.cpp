#include "core/gltf/write_obj.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "tests/core/mesh/mesh_fixtures.h"

using namespace rivage::test;

namespace {

std::string textOf(const Mesh& mesh, const OutputOptions& options = {}) {
    const auto bytes = writeObj(mesh, options, {});
    REQUIRE(bytes.has_value());
    return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
}

struct Counts {
    int v = 0, vn = 0, f = 0, o = 0, g = 0;
};

Counts countLines(const std::string& text) {
    Counts counts;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        counts.v += line.rfind("v ", 0) == 0 ? 1 : 0;
        counts.vn += line.rfind("vn ", 0) == 0 ? 1 : 0;
        counts.f += line.rfind("f ", 0) == 0 ? 1 : 0;
        counts.o += line.rfind("o ", 0) == 0 ? 1 : 0;
        counts.g += line.rfind("g ", 0) == 0 ? 1 : 0;
    }
    return counts;
}

Mesh cubeMesh(const OutputOptions& options = {}) {
    VoxelGrid grid = ballGrid(1, 2);
    grid.materials.raw()[1].color = {255, 51, 0, 255};
    grid.labels.raw()[1] = "red\ncube 1";
    return build(grid, options).mesh;
}

}  // namespace

TEST_SUITE_BEGIN("core/gltf");

TEST_CASE("writeObj: a cube, line by line") {
    const OutputOptions options{
        .shading = Shading::flat, .voxelSize = 0.25, .pivot = Pivot::corner, .up = UpAxis::z};
    const std::string text = textOf(cubeMesh(options), options);
    CHECK(text.find("metres, z up\no red_cube_1\ng red_cube_1 opaque\nv 0 0 0 1 0.2 0\n") !=
          std::string::npos);
    CHECK(text.find("v 0.25 0.25 0.25 1 0.2 0\n") != std::string::npos);
    const Counts counts = countLines(text);
    CHECK(counts.v == 8);
    CHECK(counts.vn == 0);
    CHECK(counts.f == 6);
}

TEST_CASE("writeObj: all quads and normals of all parts, with running numbers") {
    const Mesh mesh = build(islandGrid(), {}, 0.3).mesh;
    const std::string text = textOf(mesh);
    const Counts counts = countLines(text);
    CHECK(counts.o == 2);
    CHECK(counts.g == 2);
    CHECK(2 * static_cast<std::size_t>(counts.f) == triangleCount(mesh));
    CHECK(static_cast<std::size_t>(counts.v) == vertexCount(mesh));
    CHECK(counts.vn == counts.v);
    // The last face is that of the last quad, its numbers count from 1 over all parts.
    const MeshPrimitive& last = mesh.parts[1].primitives[0];
    const std::size_t before = mesh.parts[0].primitives[0].positions.size();
    std::string expected = "f";
    for (const std::uint32_t v : last.quads.back()) {
        const std::string number = std::to_string(before + v + 1);
        expected += " " + number + "//" + number;
    }
    CHECK(text.substr(text.rfind("f ")) == expected + "\n");
}

TEST_CASE("writeObj: numbers give back the floats of the mesh") {
    const OutputOptions options{.pivot = Pivot::world, .up = UpAxis::z};
    const Mesh mesh = build(ballGrid(6, 3), options, 0.4).mesh;
    std::istringstream lines(textOf(mesh, options));
    std::size_t v = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("v ", 0) != 0) continue;
        Vec3f read;
        std::istringstream(line.substr(2)) >> read.x() >> read.y() >> read.z();
        CHECK(read == (0.1 * mesh.parts[0].primitives[0].positions[v++]).cast<float>());
    }
    CHECK(v == vertexCount(mesh));
}

TEST_CASE("reject: no face, no number, no room, no time") {
    const Mesh mesh = cubeMesh();
    CHECK(writeObj(Mesh{}, {}, {}).error().code == ErrorCode::emptyGrid);
    Mesh broken = mesh;
    broken.parts[0].primitives[0].positions[0].x() = std::numeric_limits<double>::infinity();
    CHECK(writeObj(broken, {}, {}).error().code == ErrorCode::internal);
    RunContext run;
    run.limits.maxOutputBytes = textOf(mesh).size();
    CHECK(writeObj(mesh, {}, run).has_value());
    --run.limits.maxOutputBytes;
    CHECK(writeObj(mesh, {}, run).error().code == ErrorCode::outputTooLarge);
    run.stopRequested = [] { return true; };
    CHECK(writeObj(mesh, {}, run).error().code == ErrorCode::cancelled);
}

TEST_SUITE_END();
