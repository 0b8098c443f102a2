#include "core/gltf/write_glb.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/gltf/placement.h"
#include "core/gltf/quantization.h"
#include "tests/core/gltf/glb_reader.h"
#include "tests/core/mesh/mesh_fixtures.h"

using namespace rivage::test;

namespace {

using Row = std::array<double, 3>;
// A triangle as its corners in order, the smallest first, each with place and colour.
using Corner = std::pair<Row, std::array<std::uint16_t, 4>>;
using Triangle = std::array<Corner, 3>;

Row rounded(const std::array<float, 3>& position, const Quantization& grid) {
    Row row;
    for (int i = 0; i < 3; ++i)
        row[i] = std::floor((position[i] - grid.origin[i]) / grid.step() + 0.5);
    return row;
}

std::vector<Triangle> trianglesOf(const ReadPrimitive& primitive, const Quantization& grid) {
    std::vector<Triangle> triangles;
    for (std::size_t i = 0; i < primitive.indices.size(); i += 3) {
        Triangle t;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = primitive.indices[i + k];
            t[k].first = rounded(primitive.positions[v], grid);
            if (!primitive.colors.empty()) t[k].second = primitive.colors[v];
        }
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        triangles.push_back(t);
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

ReadGlb written(const Mesh& mesh, const OutputOptions& options = {}) {
    const auto bytes = writeGlb(mesh, options, {{"energy", 1.5}}, {});
    REQUIRE(bytes.has_value());
    return readGlb(*bytes);
}

std::set<std::array<float, 3>> placesOf(const ReadPrimitive& primitive) {
    return {primitive.positions.begin(), primitive.positions.end()};
}

constexpr OutputOptions kPlain{.compression = Compression::none};

}  // namespace

TEST_SUITE_BEGIN("core/gltf");

TEST_CASE("writeGlb: names, generator, report and part labels are in the file") {
    const ReadGlb glb = written(build(islandGrid(), {.parts = Parts::interfaces}).mesh);
    CHECK(glb.json.at("asset").at("version") == "2.0");
    CHECK(glb.json["asset"].at("generator").get<std::string>().rfind("Rivage ", 0) == 0);
    CHECK(glb.json["asset"].at("extras").at("rivage").at("energy") == 1.5);
    REQUIRE(glb.json.at("nodes").size() == 3);
    CHECK(glb.json["nodes"][1].at("name") == "label 1 | label 2");
    CHECK(glb.json["nodes"][1].at("extras").at("outer") == "label 2");
    CHECK(glb.json["meshes"][2].at("name") == "label 2");
    CHECK(glb.json["materials"][0].at("name") == "opaque");
    CHECK(glb.json["scenes"][0].at("nodes") == nlohmann::json{0, 1, 2});
    CHECK(glb.json["extensionsRequired"] == nlohmann::json{"KHR_draco_mesh_compression"});
}

TEST_CASE("writeGlb: plain buffers hold the mesh, turned and scaled") {
    const Built built = build(islandGrid(), {}, 0.3);
    const ReadGlb glb = written(built.mesh, kPlain);
    CHECK_FALSE(glb.json.contains("extensionsUsed"));
    for (std::size_t part = 0; part < built.mesh.parts.size(); ++part) {
        const MeshPrimitive& source = built.mesh.parts[part].primitives[0];
        const ReadPrimitive read = glb.primitive(part, 0);
        REQUIRE(read.positions.size() == source.positions.size());
        for (std::size_t v = 0; v < read.positions.size(); ++v) {
            // Bottom centre of 16 x 16 voxels of 0.1 m; y up.
            const Vec3d expected = 0.1 * Vec3d(source.positions[v].x() - 8, source.positions[v].z(),
                                               8 - source.positions[v].y());
            for (int i = 0; i < 3; ++i) CHECK(std::abs(read.positions[v][i] - expected[i]) < 1e-6);
            CHECK(read.normals[v][1] == source.normals[v].z());
            CHECK(read.normals[v][2] == -source.normals[v].y());
        }
        CHECK(read.colors == source.colors);
        CHECK(read.indices.size() == 6 * source.quads.size());
    }
}

TEST_CASE("differential: Draco decodes to the same triangles and colours as plain buffers") {
    for (const int speed : {0, 5, 10}) {
        CAPTURE(speed);
        const Built built =
            build(colored(randomGrid(9, {7, 8, 6}, 3)), {.parts = Parts::interfaces}, 0.4);
        const OutputOptions options{.dracoSpeed = speed};
        const ReadGlb packed = written(built.mesh, options);
        const ReadGlb plain = written(built.mesh, kPlain);
        const Quantization grid =
            quantizationOf(built.mesh, placementOf(built.mesh, options), options);
        for (std::size_t part = 0; part < built.mesh.parts.size(); ++part)
            CHECK(trianglesOf(packed.primitive(part, 0), grid) ==
                  trianglesOf(plain.primitive(part, 0), grid));
    }
}

TEST_CASE("writeGlb: places that parts share are bit-equal after decoding") {
    const Built built = build(islandGrid(24), {}, 0.4);
    const auto sharedOf = [&](const OutputOptions& options) {
        const ReadGlb glb = written(built.mesh, options);
        const auto sea = placesOf(glb.primitive(0, 0));
        const auto hill = placesOf(glb.primitive(1, 0));
        return std::count_if(hill.begin(), hill.end(),
                             [&](const auto& place) { return sea.count(place) > 0; });
    };
    const auto expected = sharedOf(kPlain);
    CHECK(expected > 30);
    CHECK(sharedOf({}) == expected);
}

TEST_CASE("writeGlb: bounds in the file are those of the decoded positions") {
    const ReadGlb glb = written(build(islandGrid(), {}, 0.4).mesh);
    for (std::size_t part = 0; part < 2; ++part) {
        const auto& accessor =
            glb.json["accessors"]
                    [glb.json["meshes"][part]["primitives"][0]["attributes"]["POSITION"]
                         .get<std::size_t>()];
        const ReadPrimitive read = glb.primitive(part, 0);
        for (std::size_t i = 0; i < 3; ++i) {
            float low = std::numeric_limits<float>::infinity();
            float high = -low;
            for (const auto& position : read.positions) {
                low = std::min(low, position[i]);
                high = std::max(high, position[i]);
            }
            CHECK(accessor.at("min")[i].get<float>() == low);
            CHECK(accessor.at("max")[i].get<float>() == high);
        }
    }
}

TEST_CASE("writeGlb: flat shading and no colours leave their attributes out") {
    const OutputOptions bare{.colors = Colors::none, .shading = Shading::flat};
    for (const Compression compression : {Compression::draco, Compression::none}) {
        const ReadGlb glb = written(build(islandGrid(), bare).mesh, {.compression = compression});
        const auto& attributes = glb.json["meshes"][0]["primitives"][0]["attributes"];
        CHECK(attributes.size() == 1);
        CHECK(attributes.contains("POSITION"));
    }
}

TEST_CASE("placementOf: the pivot goes to the origin, up is y or z") {
    Mesh mesh;
    mesh.boxMin = {2, 4, 6};
    mesh.boxMax = {4, 10, 7};
    const auto corner = [&](Pivot pivot, UpAxis up) {
        const OutputOptions options{.voxelSize = 0.5, .pivot = pivot, .up = up};
        return placementOf(mesh, options).position({2, 4, 6});
    };
    CHECK(corner(Pivot::corner, UpAxis::z) == Vec3f(0, 0, 0));
    CHECK(corner(Pivot::bottom, UpAxis::z) == Vec3f(-0.5F, -1.5F, 0));
    CHECK(corner(Pivot::center, UpAxis::z) == Vec3f(-0.5F, -1.5F, -0.25F));
    CHECK(corner(Pivot::world, UpAxis::z) == Vec3f(1, 2, 3));
    CHECK(corner(Pivot::bottom, UpAxis::y) == Vec3f(-0.5F, 0, 1.5F));
    CHECK(corner(Pivot::world, UpAxis::y) == Vec3f(1, 3, -2));
}

TEST_CASE("quantizationOf: automatic bits give steps of 1/128 voxel within 11 to 20 bits") {
    const auto gridOf = [](int side, std::optional<int> bits = {}) {
        Mesh mesh;
        mesh.boxMax = Vec3d(side, 3, 3);
        const OutputOptions options{.dracoPositionBits = bits, .voxelSize = 1};
        return quantizationOf(mesh, placementOf(mesh, options), options);
    };
    CHECK(gridOf(3).bits == 11);
    CHECK(gridOf(68).bits == 14);
    CHECK(gridOf(256).bits == 16);
    CHECK(gridOf(1000000).bits == 20);
    CHECK(gridOf(3).step() == 1 / 128.0);
    CHECK(gridOf(256).step() == 1 / 128.0);
    CHECK(gridOf(1000000).range >= 1000000);
    CHECK(gridOf(100, 8).bits == 8);
    CHECK(std::abs(gridOf(100, 8).step() - 100 / 255.0) < 1e-5);
}

TEST_CASE("quantizationOf: the grid covers every position, for every pivot and axis") {
    const Mesh mesh = build(islandGrid(), {}, 3).mesh;
    for (const std::optional<int> bits : {std::optional<int>(), std::optional<int>(9)})
        for (const Pivot pivot : {Pivot::bottom, Pivot::corner, Pivot::world})
            for (const UpAxis up : {UpAxis::y, UpAxis::z}) {
                const OutputOptions options{.dracoPositionBits = bits, .pivot = pivot, .up = up};
                const Placement placement = placementOf(mesh, options);
                const Quantization grid = quantizationOf(mesh, placement, options);
                const Vec3f origin(grid.origin[0], grid.origin[1], grid.origin[2]);
                for (const MeshPart& part : mesh.parts)
                    for (const Vec3d& position : part.primitives[0].positions) {
                        const Vec3f offset = placement.position(position) - origin;
                        CHECK(offset.minCoeff() >= -1e-6F);
                        CHECK(offset.maxCoeff() <= grid.range + 1e-6F);
                    }
            }
}

TEST_CASE("writeGlb: automatic bits keep flat walls flat and lattice places exact") {
    const Mesh mesh = build(ballGrid(9, 4)).mesh;
    const ReadGlb glb = written(mesh, {.voxelSize = 1, .pivot = Pivot::corner});
    std::set<float> coordinates;
    for (const auto& position : glb.primitive(0, 0).positions)
        coordinates.insert(position.begin(), position.end());
    CHECK(coordinates.size() == 20);  // 10 planes along each axis; y up makes one axis negative
    for (const float x : coordinates) CHECK(std::abs(x - std::round(x)) < 2e-6F);
}

TEST_CASE("writeGlb: positions are off by at most half a step, whatever the bits") {
    const Built built = build(ballGrid(20, 9.5), {}, 0.4);
    for (const int bits : {8, 11, 16, 20}) {
        CAPTURE(bits);
        const OutputOptions options{.dracoPositionBits = bits, .voxelSize = 1};
        const Placement placement = placementOf(built.mesh, options);
        const Quantization grid = quantizationOf(built.mesh, placement, options);
        const ReadPrimitive read = written(built.mesh, options).primitive(0, 0);
        double worst = 0;
        for (const auto& p : read.positions) {
            double nearest = std::numeric_limits<double>::infinity();
            for (const Vec3d& source : built.mesh.parts[0].primitives[0].positions)
                nearest = std::min(nearest, static_cast<double>((placement.position(source) -
                                                                 Vec3f(p[0], p[1], p[2]))
                                                                    .cwiseAbs()
                                                                    .maxCoeff()));
            worst = std::max(worst, nearest);
        }
        CHECK(worst <= 0.5 * grid.step() + 2e-6);
    }
}

TEST_CASE("writeGlb: metal, glass, light and cloud become what glTF has for them") {
    VoxelGrid grid = colored(makeGrid({5, 2, 2}, 5, [](const Vec3i& v) { return v.x() + 1; }));
    auto& materials = grid.materials.raw();
    materials[2].kind = MaterialClass::metal;
    materials[2].metallic = 1;
    materials[2].roughness = 0.25;
    materials[3].kind = MaterialClass::glass;
    materials[3].transmission = 0.75;
    materials[3].ior = 1.25;
    materials[4].kind = MaterialClass::emissive;
    materials[4].emission = 1;
    materials[4].emissiveStrength = 8;
    materials[4].color = {255, 0, 0, 255};
    materials[5].kind = MaterialClass::cloud;
    materials[5].transmission = 0.5;
    const ReadGlb glb = written(build(grid).mesh);
    const auto material = [&](std::size_t part) {
        const std::size_t index = glb.json["meshes"][part]["primitives"][0]["material"];
        return glb.json["materials"][index];
    };
    CHECK(material(0)["pbrMetallicRoughness"].at("metallicFactor") == 0);
    CHECK_FALSE(material(1)["pbrMetallicRoughness"].contains("metallicFactor"));  // default: 1
    CHECK(material(1)["pbrMetallicRoughness"].at("roughnessFactor") == 0.25);
    const auto glass = material(2)["extensions"];
    CHECK(glass.at("KHR_materials_transmission").at("transmissionFactor") == 0.75);
    CHECK(glass.at("KHR_materials_ior").at("ior") == 1.25);
    CHECK_FALSE(material(2).contains("alphaMode"));
    CHECK(material(3).at("emissiveFactor") == nlohmann::json{1, 0, 0});
    CHECK(material(3)["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] == 8);
    CHECK(material(4).at("alphaMode") == "BLEND");
    CHECK(material(4)["pbrMetallicRoughness"].at("baseColorFactor")[3] == 0.5);
    CHECK(glb.json["extensionsUsed"].size() == 4);
}

TEST_CASE("writeGlb: more than 65535 vertices take 32-bit indices") {
    // Neighbours differ in colour, so each face has vertices of its own; few enough for one stream.
    VoxelGrid grid = colored(
        makeGrid({100, 100, 1}, 5, [](const Vec3i& v) { return 1 + (v.x() + 2 * v.y()) % 5; }));
    for (std::uint32_t i = 1; i < grid.materials.size(); ++i)
        grid.materials[static_cast<MaterialId>(i)].label = Label{1};
    const Mesh mesh = build(std::move(grid)).mesh;
    CHECK(vertexCount(mesh) > 65535);
    for (const Compression compression : {Compression::draco, Compression::none}) {
        const ReadGlb glb = written(mesh, {.compression = compression});
        const std::size_t indices = glb.json["meshes"][0]["primitives"][0]["indices"];
        CHECK(glb.json["accessors"][indices].at("componentType") == 5125);
        CHECK(glb.primitive(0, 0).indices.size() == 3 * triangleCount(mesh));
    }
}

TEST_CASE("writeGlb: names that are not UTF-8 are repaired, odd extras are written") {
    VoxelGrid grid = ballGrid(3, 1.5);
    grid.labels.raw()[1] = "r\xE9gion \"1\"\n";
    const auto bytes = writeGlb(build(grid).mesh, {},
                                {{"big", std::uint64_t{5000000000}},
                                 {"none", nullptr},
                                 {"text", "\xFF"},
                                 {"list", {1, true, "x", nlohmann::ordered_json::object()}}},
                                {});
    REQUIRE(bytes.has_value());
    const ReadGlb glb = readGlb(*bytes);
    CHECK(glb.json["nodes"][0]["name"] == "r\xEF\xBF\xBDgion \"1\"\n");
    CHECK(glb.json["asset"]["extras"]["rivage"]["big"] == 5e9);
    CHECK_FALSE(glb.json["asset"]["extras"]["rivage"].contains("none"));
    CHECK(glb.json["asset"]["extras"]["rivage"]["text"] == "\xEF\xBF\xBD");
}

TEST_CASE("reject: no face, no number, no room, no time") {
    const auto empty = writeGlb(Mesh{}, {}, {}, {});
    REQUIRE_FALSE(empty);
    CHECK(empty.error().code == ErrorCode::emptyGrid);

    const Mesh mesh = build(islandGrid()).mesh;
    for (const Compression compression : {Compression::draco, Compression::none}) {
        const OutputOptions options{.compression = compression};
        Mesh broken = mesh;
        broken.parts[1].primitives[0].positions[5].y() = std::nan("");
        const auto notANumber = writeGlb(broken, options, {}, {});
        REQUIRE_FALSE(notANumber);
        CHECK(notANumber.error().code == ErrorCode::internal);

        const std::size_t size = writeGlb(mesh, options, {}, {})->size();
        RunContext run;
        run.limits.maxOutputBytes = size;
        CHECK(writeGlb(mesh, options, {}, run).has_value());
        run.limits.maxOutputBytes = size - 1;
        const auto large = writeGlb(mesh, options, {}, run);
        REQUIRE_FALSE(large);
        CHECK(large.error().code == ErrorCode::outputTooLarge);
        CHECK(large.error().limit == size - 1);

        const auto stopped = writeGlb(mesh, options, {}, {.stopRequested = [] { return true; }});
        REQUIRE_FALSE(stopped);
        CHECK(stopped.error().code == ErrorCode::cancelled);
    }
}

TEST_CASE("determinism: the same bytes for threads 1, 2, 7") {
    const Built built =
        build(colored(randomGrid(4, {16, 16, 16}, 4)), {.parts = Parts::interfaces}, 0.4);
    const auto bytes = [&](int threads) {
        return *writeGlb(built.mesh, {}, {}, {.threads = threads});
    };
    const std::vector<std::byte> one = bytes(1);
    CHECK((bytes(2) == one));
    CHECK((bytes(7) == one));
}

TEST_SUITE_END();
