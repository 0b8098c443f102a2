#include "core/gltf/chunks.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "core/gltf/write_glb.h"
#include "tests/core/gltf/glb_reader.h"
#include "tests/core/mesh/mesh_fixtures.h"

using namespace rivage::test;

TEST_SUITE("core/gltf") {
    TEST_CASE("cutQuads: each quad once, in chunks that are small enough and not too many") {
        const Mesh mesh = build(ballGrid(24, 11), {}, 0.4).mesh;
        const MeshPrimitive& primitive = mesh.parts[0].primitives[0];
        for (const std::size_t most : {1, 7, 100, 1000, 100000}) {
            CAPTURE(most);
            const std::vector<Chunk> chunks = cutQuads(primitive, most, {});
            std::vector<std::uint32_t> all;
            for (const Chunk& chunk : chunks) {
                CHECK(chunk.size() <= most);
                CHECK_FALSE(chunk.empty());
                CHECK(std::is_sorted(chunk.begin(), chunk.end()));
                all.insert(all.end(), chunk.begin(), chunk.end());
            }
            std::sort(all.begin(), all.end());
            Chunk expected(primitive.quads.size());
            std::iota(expected.begin(), expected.end(), 0U);
            CHECK(all == expected);
            if (most >= 100) CHECK(chunks.size() <= 3 * primitive.quads.size() / most + 1);
        }
    }

    TEST_CASE("chunkOf: the same faces with the same colours, every vertex used") {
        const Mesh mesh = build(colored(randomGrid(4, {6, 6, 6}, 2)), {}, 0.3).mesh;
        for (const MeshPart& part : mesh.parts)
            for (const MeshPrimitive& primitive : part.primitives)
                for (const Chunk& quads : cutQuads(primitive, 20, {})) {
                    const MeshPrimitive chunk = chunkOf(primitive, quads);
                    REQUIRE(chunk.quads.size() == quads.size());
                    std::vector<bool> used(chunk.positions.size());
                    for (std::size_t q = 0; q < quads.size(); ++q)
                        for (std::size_t k = 0; k < 4; ++k) {
                            const std::uint32_t from = primitive.quads[quads[q]][k];
                            const std::uint32_t to = chunk.quads[q][k];
                            used[to] = true;
                            CHECK(chunk.positions[to] == primitive.positions[from]);
                            CHECK(chunk.normals[to] == primitive.normals[from]);
                            CHECK(chunk.colors[to] == primitive.colors[from]);
                            for (std::size_t l = 0; l < 4; ++l)
                                CHECK((chunk.points[chunk.quads[q][l]] == chunk.points[to]) ==
                                      (primitive.points[primitive.quads[quads[q]][l]] ==
                                       primitive.points[from]));
                        }
                    CHECK(std::count(used.begin(), used.end(), false) == 0);
                }
    }

    TEST_CASE("writeGlb: a large part has several primitives, and no cracks between them") {
        const Built built = build(ballGrid(100, 49), {}, 0.3);
        const MeshPrimitive& whole = built.mesh.parts[0].primitives[0];
        REQUIRE(whole.quads.size() > 40000);
        const auto one = writeGlb(built.mesh, {}, {}, {});
        const auto two = writeGlb(built.mesh, {}, {}, {.threads = 2});
        REQUIRE(one);
        REQUIRE(two);
        CHECK(*one == *two);
        const ReadGlb glb = readGlb(*one);
        const std::size_t count = glb.json["meshes"][0]["primitives"].size();
        CHECK(count >= 2);
        std::set<std::array<float, 3>> places;
        std::size_t indices = 0;
        for (std::size_t p = 0; p < count; ++p) {
            const ReadPrimitive read = glb.primitive(0, p);
            indices += read.indices.size();
            places.insert(read.positions.begin(), read.positions.end());
        }
        CHECK(indices == 6 * whole.quads.size());
        // Seams that were rounded apart would show as more places.
        const std::set<std::uint32_t> points(whole.points.begin(), whole.points.end());
        CHECK(places.size() <= points.size());
        CHECK(places.size() > 0.99 * static_cast<double>(points.size()));
    }
}
