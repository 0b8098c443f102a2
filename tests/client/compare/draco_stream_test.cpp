#include <sys/resource.h>

#include <doctest/doctest.h>

#include <functional>
#include <random>

#include "client/compare/measures.h"
#include "client/compare/surface.h"
#include "glb_builder.h"

using namespace rivage::client;
using namespace rivage::client::test;
using rivage::proto::Json;

namespace {

GlbSource small() { return dracoGlb({ball({0, 0, 0}, 1, 6)}, 12); }

void refuseSpoiled(const char* why, const std::function<void(GlbSource&)>& spoil) {
    GlbSource glb = small();
    spoil(glb);
    refuse(glb.bytes(), why);
}

Json& extensionOf(GlbSource& glb) {
    return glb.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
}

}  // namespace

TEST_SUITE("client/compare") {
    TEST_CASE("readSurface: a Draco stream gives back the mesh up to its rounding") {
        // The flat triangles at the poles are what an encoder may leave out: a ball without them.
        Shape shape = cube(-1, 1);
        const auto surface = readSurface(dracoGlb({shape, shifted(shape, {4, 0, 0})}, 14).bytes());
        REQUIRE(surface);
        CHECK(surface->format == "glb with draco");
        CHECK(surface->parts.size() == 2);
        CHECK(surface->triangles.size() == 24);
        const Measures all = measure(*surface, 0, 24);
        REQUIRE(all.volume);
        CHECK(*all.volume == doctest::Approx(16).epsilon(1e-3));
        CHECK(all.high.x() == doctest::Approx(5).epsilon(1e-3));
        CHECK(surface->bytes["draco"].get<std::size_t>() > 50);
    }

    TEST_CASE("reject: every proper prefix of a stream") {
        const GlbSource glb = dracoGlb({cube(0, 1)}, 10);
        REQUIRE(readSurface(glb.bytes()));
        const std::size_t size = glb.json["bufferViews"][0]["byteLength"];
        for (std::size_t cut = 0; cut < size; ++cut) {
            GlbSource part = glb;
            part.json["bufferViews"][0]["byteLength"] = cut;
            const auto surface = readSurface(part.bytes());
            CAPTURE(cut);
            REQUIRE_FALSE(surface);
            REQUIRE(surface.error().exit == ExitCode::refused);
        }
    }

    TEST_CASE("reject: counts, ids and heads that lie") {
        const char* const counts = "other counts than its accessors";
        const auto triangles = [](int more) {
            return [more](GlbSource& glb) {
                Json& count = glb.json["accessors"][1]["count"];
                count = count.get<int>() + 3 * more;
            };
        };
        refuseSpoiled(counts, triangles(1));
        refuseSpoiled(counts, triangles(-1));
        refuseSpoiled(counts, [](GlbSource& glb) { glb.json["accessors"][0]["count"] = 3; });
        refuseSpoiled("make no sense",
                      [](GlbSource& glb) { glb.json["accessors"][1]["count"] = 4; });
        refuseSpoiled("lacks an attribute",
                      [](GlbSource& glb) { extensionOf(glb)["attributes"]["POSITION"] = 9; });
        refuseSpoiled("lacks an attribute",
                      [](GlbSource& glb) { extensionOf(glb)["attributes"]["COLOR_0"] = 3; });
        refuseSpoiled("lacks an attribute",
                      [](GlbSource& glb) { extensionOf(glb).erase("attributes"); });
        refuseSpoiled("there is no element",
                      [](GlbSource& glb) { extensionOf(glb)["bufferView"] = 5; });
        refuseSpoiled("no header", [](GlbSource& glb) { glb.binary[0] = 'X'; });
        refuseSpoiled("version 2.2", [](GlbSource& glb) { glb.binary[5] = 1; });
        refuseSpoiled("holds no mesh", [](GlbSource& glb) { glb.binary[7] = 0; });
        refuseSpoiled("metadata", [](GlbSource& glb) { glb.binary[10] = static_cast<char>(0x80); });
    }

    TEST_CASE("reject: a stream that announces millions of triangles in a few bytes") {
        GlbSource glb = small();
        glb.json["accessors"][0]["count"] = 3'000'000;
        glb.json["accessors"][1]["count"] = 9'000'000;
        // Behind the head: how the mesh is walked, vertices, faces, seven bits a byte.
        const std::string three = "\xC0\x8D\xB7\x01";
        glb.binary.replace(12, 4, three);
        glb.binary.replace(16, 4, three);
        refuse(glb.bytes(), "more triangles than it can hold");
    }

    TEST_CASE("property: streams changed at random are read or refused, in bounded memory") {
        const GlbSource good = small();
        const std::size_t size = good.json["bufferViews"][0]["byteLength"];
        std::mt19937 random(17);
        int read = 0;
        for (int i = 0; i < 20'000; ++i) {
            GlbSource glb = good;
            for (int k = 0; k < 1 + i % 3; ++k)
                glb.binary[11 + random() % (size - 11)] = static_cast<char>(random());
            const auto surface = readSurface(glb.bytes());
            if (!surface) {
                REQUIRE(surface.error().exit == ExitCode::refused);
                continue;
            }
            ++read;
            for (const auto& triangle : surface->triangles)
                for (const std::uint32_t v : triangle) REQUIRE(v < surface->positions.size());
        }
        CHECK(read > 100);
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        CHECK(usage.ru_maxrss < 600'000);  // kB, of the whole test program
    }
}
