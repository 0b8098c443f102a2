#include <doctest/doctest.h>

#include <functional>
#include <random>

#include "client/compare/measures.h"
#include "client/compare/surface.h"
#include "glb_builder.h"

using namespace rivage::client;
using namespace rivage::client::test;
using Eigen::Vector3f;
using rivage::proto::Json;

namespace {

/// A small GLB that is read when nothing is spoiled.
GlbSource small() { return plainGlb({painted(cube(0, 1), {0.25F, 0.5F, 1})}); }

void refuseSpoiled(const char* why, const std::function<void(Json&)>& spoil) {
    GlbSource glb = small();
    spoil(glb.json);
    refuse(glb.bytes(), why);
}

/// The surface of a cube whose node is changed.
Surface placed(const std::function<void(Json&)>& change) {
    GlbSource glb = plainGlb({cube(0, 1)});
    change(glb.json["nodes"][0]);
    auto surface = readSurface(glb.bytes());
    REQUIRE(surface);
    return *surface;
}

Measures boxOf(const Surface& surface) { return measure(surface, 0, surface.triangles.size()); }

}  // namespace

TEST_SUITE("client/compare") {
    TEST_CASE("readSurface: a plain GLB gives back what was written") {
        const Shape shape = painted(cube(0, 1), {0.25F, 0.5F, 1});
        const auto surface = readSurface(plainGlb({shape, shifted(shape, {3, 0, 0})}).bytes());
        REQUIRE(surface);
        CHECK(surface->format == "glb");
        CHECK(surface->positions.size() == 16);
        CHECK(surface->triangles.size() == 24);
        CHECK(surface->primitives == 2);
        REQUIRE(surface->parts.size() == 2);
        CHECK(surface->parts[1].name == "part 2");
        CHECK(surface->parts[1].first == 12);
        CHECK(surface->positions[8] == Vector3f(3, 0, 0));
        CHECK(surface->colors[3] == Vector3f(0.25F, 0.5F, 1));
        CHECK(surface->report.is_null());
        CHECK(surface->bytes["POSITION"] == 2 * 8 * 12);
        CHECK(surface->bytes["indices"] == 2 * 36 * 4);
    }

    TEST_CASE("readSurface: nodes move, scale, turn and mirror what is below them") {
        const auto box = boxOf(placed([](Json& node) {
            node["translation"] = {10, 0, 0};
            node["scale"] = {2, 3, 4};
        }));
        CHECK(box.low == Eigen::Vector3d(10, 0, 0));
        CHECK(box.high == Eigen::Vector3d(12, 3, 4));
        const double half = std::sqrt(0.5);
        const auto turn = boxOf(placed([&](Json& node) { node["rotation"] = {half, 0, 0, half}; }));
        CHECK(turn.low.isApprox(Eigen::Vector3d(0, -1, 0), 1e-6));
        const auto mirror = boxOf(placed([](Json& node) { node["scale"] = {-1, 1, 1}; }));
        REQUIRE(mirror.volume);
        CHECK(*mirror.volume == doctest::Approx(1));  // its faces still point outwards
        const auto matrix = boxOf(placed(
            [](Json& node) { node["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1}; }));
        CHECK(matrix.low == Eigen::Vector3d(7, 8, 9));
    }

    TEST_CASE("readSurface: integer colours, indices of 16 bits, and none") {
        GlbSource glb = plainGlb({plane(1, 1, 0)});
        const std::uint16_t indices[] = {0, 1, 3};
        const std::uint16_t colors[] = {0, 65535, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
        const auto add = [&](const void* data, std::size_t bytes) {
            glb.json["bufferViews"].push_back(
                {{"buffer", 0}, {"byteOffset", glb.binary.size()}, {"byteLength", bytes}});
            glb.binary.append(static_cast<const char*>(data), bytes);
            glb.json["buffers"][0]["byteLength"] = glb.binary.size();
            return glb.json["bufferViews"].size() - 1;
        };
        Json& accessors = glb.json["accessors"];
        accessors[1] = {{"bufferView", add(indices, sizeof indices)},
                        {"componentType", 5123},
                        {"type", "SCALAR"},
                        {"count", 3}};
        accessors.push_back({{"bufferView", add(colors, sizeof colors)},
                             {"componentType", 5123},
                             {"normalized", true},
                             {"type", "VEC3"},
                             {"count", 4}});
        Json& primitive = glb.json["meshes"][0]["primitives"][0];
        primitive["attributes"]["COLOR_0"] = 2;
        const auto surface = readSurface(glb.bytes());
        REQUIRE(surface);
        CHECK(surface->triangles.size() == 1);
        CHECK(surface->colors[0] == Vector3f(0, 1, 0));
        primitive.erase("indices");
        refuse(glb.bytes(), "not those of triangles");  // four vertices
    }

    TEST_CASE("readSurface: the colour of a material is that of its vertices") {
        GlbSource glb = plainGlb({cube(0, 1)});
        glb.json["materials"] = {
            {{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 0, 1}}}}}};
        glb.json["meshes"][0]["primitives"][0]["material"] = 0;
        const auto surface = readSurface(glb.bytes());
        REQUIRE(surface);
        REQUIRE(surface->colors.size() == 8);
        CHECK(surface->colors[5] == Vector3f(0.5F, 0.25F, 0));
        CHECK(surface->materials == 1);
    }

    TEST_CASE("reject: every proper prefix, and anything after the end") {
        const std::string bytes = small().bytes();
        REQUIRE(readSurface(bytes));
        for (std::size_t size = 0; size < bytes.size(); ++size) {
            const auto surface = readSurface(bytes.substr(0, size));
            REQUIRE_FALSE(surface);
            REQUIRE(surface.error().exit == ExitCode::refused);
        }
        refuse(bytes + "x", "the GLB says");
    }

    TEST_CASE("reject: a prefix whose header says so") {
        std::string bytes = small().bytes();
        while (bytes.size() > 12) {
            bytes.pop_back();
            const auto size = static_cast<std::uint32_t>(bytes.size());
            bytes.replace(8, 4, reinterpret_cast<const char*>(&size), 4);
            REQUIRE_FALSE(readSurface(bytes));
        }
    }

    TEST_CASE("reject: accessors and views that lie") {
        const char* const beyond = "reaches beyond its buffer view";
        refuseSpoiled(beyond, [](Json& json) { json["accessors"][0]["count"] = 9; });
        refuseSpoiled(beyond, [](Json& json) { json["accessors"][0]["count"] = 9e15; });
        refuseSpoiled(beyond, [](Json& json) { json["accessors"][0]["byteOffset"] = 4; });
        refuseSpoiled(beyond, [](Json& json) { json["accessors"][0]["byteOffset"] = 9e15; });
        refuseSpoiled(beyond, [](Json& json) { json["bufferViews"][0]["byteStride"] = 9e15; });
        const char* const sense = "makes no sense";
        refuseSpoiled(sense, [](Json& json) { json["accessors"][0]["count"] = -1; });
        refuseSpoiled(sense, [](Json& json) { json["accessors"][0]["count"] = 1.5; });
        refuseSpoiled(sense, [](Json& json) { json["accessors"][0]["count"] = 0; });
        refuseSpoiled(sense, [](Json& json) { json["accessors"][0]["count"] = "many"; });
        refuseSpoiled(sense, [](Json& json) { json["accessors"][0]["componentType"] = 1; });
        refuseSpoiled(sense, [](Json& json) { json["accessors"][0]["type"] = "MAT4"; });
        refuseSpoiled(sense, [](Json& json) { json["bufferViews"][0]["byteStride"] = 1; });
        const char* const view = "reaches beyond the buffer";
        refuseSpoiled(view, [](Json& json) { json["bufferViews"][1]["byteLength"] = 999; });
        refuseSpoiled(view, [](Json& json) { json["bufferViews"][1]["byteOffset"] = 9e15; });
        refuseSpoiled("longer than the file",
                      [](Json& json) { json["buffers"][0]["byteLength"] = 99999; });
        refuseSpoiled("not as many colours", [](Json& json) { json["accessors"][1]["count"] = 7; });
        refuseSpoiled("three components",
                      [](Json& json) { json["accessors"][0]["type"] = "VEC2"; });
        refuseSpoiled("whole numbers",
                      [](Json& json) { json["accessors"][2]["componentType"] = 5126; });
        refuseSpoiled("those of triangles", [](Json& json) { json["accessors"][2]["count"] = 35; });
    }

    TEST_CASE("reject: elements that do not exist") {
        const char* const none = "there is no element";
        refuseSpoiled(none, [](Json& json) { json["scene"] = 1; });
        refuseSpoiled(none, [](Json& json) { json["scenes"][0]["nodes"] = {7}; });
        refuseSpoiled(none, [](Json& json) { json["nodes"][0]["mesh"] = 1; });
        refuseSpoiled(none, [](Json& json) { json["nodes"][0]["mesh"] = -1; });
        refuseSpoiled(none, [](Json& json) { json.erase("bufferViews"); });
        refuseSpoiled(none, [](Json& json) { json.erase("buffers"); });
        refuseSpoiled(none, [](Json& json) { json["accessors"][0].erase("bufferView"); });
        refuseSpoiled(none, [](Json& json) { json["meshes"][0]["primitives"][0]["material"] = 0; });
        refuseSpoiled("is no object", [](Json& json) { json["nodes"][0] = 3; });
        refuseSpoiled("no attributes",
                      [](Json& json) { json["meshes"][0]["primitives"][0].erase("attributes"); });
        refuseSpoiled("no primitives", [](Json& json) { json["meshes"][0].erase("primitives"); });
        refuseSpoiled("no triangle", [](Json& json) { json["nodes"][0].erase("mesh"); });
    }

    TEST_CASE("reject: nodes in circles, or twice") {
        refuseSpoiled("below two others", [](Json& json) { json["nodes"][0]["children"] = {0}; });
        refuseSpoiled("below two others", [](Json& json) { json["scenes"][0]["nodes"] = {0, 0}; });
        refuseSpoiled("below two others", [](Json& json) {  // not more are named than there are
            json["nodes"].push_back(Json::object());
            json["scenes"][0]["nodes"] = {0, 0};
        });
        refuseSpoiled("no proper placement", [](Json& json) { json["nodes"][0]["matrix"] = {1}; });
        refuseSpoiled("no proper rotation", [](Json& json) {
            json["nodes"][0]["rotation"] = {0, 0, 0, 0};
        });
        refuseSpoiled("not finite", [](Json& json) { json["nodes"][0]["scale"] = {1e300, 1, 1}; });
    }

    TEST_CASE("reject: what is not read here says so") {
        refuseSpoiled("EXT_meshopt_compression",
                      [](Json& json) { json["extensionsRequired"] = {"EXT_meshopt_compression"}; });
        refuseSpoiled("outside of the GLB",
                      [](Json& json) { json["buffers"][0]["uri"] = "/etc/passwd"; });
        refuseSpoiled("sparse",
                      [](Json& json) { json["accessors"][0]["sparse"] = Json::object(); });
        refuseSpoiled("not triangles",
                      [](Json& json) { json["meshes"][0]["primitives"][0]["mode"] = 1; });
        refuse(R"({"asset":{"version":"2.0"}})", "only GLB is read");
        refuse(std::string("PK\x03\x04\0\0", 6), "neither GLB nor OBJ");
        refuse("", "empty");
        std::string old = small().bytes();
        old[4] = 1;
        refuse(old, "not glTF 2.0");
    }

    TEST_CASE("reject: an index that names no vertex, a position that is no number") {
        GlbSource glb = small();
        glb.binary[glb.binary.size() - 4] = 8;
        refuse(glb.bytes(), "names no vertex");
        for (const float bad : {NAN, INFINITY}) {
            GlbSource spoiled = small();
            spoiled.binary.replace(0, 4, reinterpret_cast<const char*>(&bad), 4);
            refuse(spoiled.bytes(), "not finite");
        }
    }

    TEST_CASE("reject: more triangles or vertices than the limit, the limit itself is read") {
        const std::string bytes = small().bytes();
        CHECK(readSurface(bytes, {.maxTriangles = 12}));
        CHECK_FALSE(readSurface(bytes, {.maxTriangles = 11}));
        CHECK(readSurface(bytes, {.maxVertices = 8}));
        CHECK_FALSE(readSurface(bytes, {.maxVertices = 7}));
        CHECK_FALSE(readSurface(bytes, {.maxJsonBytes = 100}));
    }

    TEST_CASE("reject: a mesh that many nodes show does not grow beyond the limit") {
        GlbSource glb = small();
        for (int i = 1; i < 1000; ++i) {
            glb.json["nodes"].push_back({{"mesh", 0}});
            glb.json["scenes"][0]["nodes"].push_back(i);
        }
        CHECK(readSurface(glb.bytes()));
        CHECK_FALSE(readSurface(glb.bytes(), {.maxTriangles = 5000}));
    }

    TEST_CASE("reject: JSON that is too deep, twice the same, or no object") {
        const auto with = [](const std::string& json) { return container(json, "    "); };
        refuse(with(std::string(100, '[') + std::string(100, ']')), "nested");
        refuse(with(R"({"asset":1,"asset":2})"), "twice");
        refuse(with("[]"), "no object");
        refuse(with("{"), "not JSON");
        for (const char* json : {"{}", R"({"scenes":3})", R"({"scenes":[{"nodes":{}}]})",
                                 R"({"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":{}})"})
            CHECK_FALSE(readSurface(with(json)));
    }

    TEST_CASE("property: bytes changed at random are read or refused, nothing else") {
        const std::string good = small().bytes();
        std::mt19937 random(3);
        int read = 0;
        for (int i = 0; i < 20'000; ++i) {
            std::string bytes = good;
            for (int k = 0; k < 1 + i % 3; ++k)
                bytes[random() % bytes.size()] = static_cast<char>(random());
            const auto surface = readSurface(bytes);
            if (!surface) {
                REQUIRE(surface.error().exit == ExitCode::refused);
                continue;
            }
            ++read;
            for (const auto& triangle : surface->triangles)
                for (const std::uint32_t v : triangle) REQUIRE(v < surface->positions.size());
        }
        CHECK(read > 100);
    }
}
