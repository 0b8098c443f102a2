#include "core/formats/write_vox.h"

#include <doctest/doctest.h>

#include "core/formats/read_vox.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;

namespace {

Scene oneVoxelScene() {
    Scene scene;
    scene.models.emplace_back(Vec3i(3, 4, 5));
    scene.models[0].set(Vec3i(2, 3, 4), MaterialId{1});
    scene.materials.push_back({.source = 1, .color = {1, 2, 3, 255}, .name = "one"});
    scene.instances.push_back({.frames = {0}});
    return scene;
}

Scene writtenAndRead(const Scene& scene) {
    const auto bytes = writeVox(scene);
    REQUIRE(bytes);
    auto read = readVox(*bytes, {}, {});
    REQUIRE(read);
    return *std::move(read);
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("write vox: voxels, colours and materials read back the same") {
    Scene scene = oneVoxelScene();
    scene.materials.push_back(
        {.source = 2, .kind = MaterialClass::metal, .roughness = 0.3, .metallic = 0.7});
    scene.materials.push_back({.source = 3,
                               .kind = MaterialClass::glass,
                               .roughness = 0.1,
                               .transmission = 0.6,
                               .ior = 1.33});
    scene.materials.push_back({.source = 4,
                               .kind = MaterialClass::emissive,
                               .roughness = 0.5,
                               .emission = 0.8,
                               .emissiveStrength = 4});
    scene.materials.push_back({.source = 5, .kind = MaterialClass::cloud, .transmission = 0.4});
    const Scene read = writtenAndRead(scene);
    CHECK(read.models[0].size() == Vec3i(3, 4, 5));
    CHECK(read.models[0].countVoxels() == 1);
    CHECK(read.models[0].at(Vec3i(2, 3, 4)) == MaterialId{1});
    for (std::size_t i = 1; i < scene.materials.size(); ++i) {
        CAPTURE(i);
        const Material& in = scene.materials.raw()[i];
        const Material& out = read.materials.raw()[i];
        CHECK(out.source == in.source);
        CHECK(out.color == in.color);
        CHECK(out.kind == in.kind);
        CHECK(out.roughness == in.roughness);
        CHECK(out.metallic == in.metallic);
        CHECK(out.transmission == in.transmission);
        CHECK(out.ior == in.ior);
        CHECK(out.emission == in.emission);
        CHECK(out.emissiveStrength == in.emissiveStrength);
        CHECK(out.name == "one");
    }
}

TEST_CASE("write vox: instances keep their place, order, frames, names and layers") {
    Scene scene = oneVoxelScene();
    scene.models.emplace_back(Vec3i(1, 1, 1));
    Mat3i turned;
    turned << 0, -1, 0, 0, 0, 1, 1, 0, 0;
    scene.instances[0] = {.frames = {0, 1},
                          .frameTimes = {0, 6},
                          .rotation = turned,
                          .translation = Vec3i(-3, 5, 7),
                          .hidden = true,
                          .layer = 2,
                          .name = "first"};
    scene.instances.push_back({.frames = {1}, .name = "second"});
    const Scene read = writtenAndRead(scene);
    REQUIRE(read.instances.size() == 2);
    // Later instances win in this scene and earlier ones in the file, so the order turns round.
    CHECK_FALSE(read.laterInstanceWins);
    const Instance& first = read.instances[1];
    CHECK(first.name == "first");
    CHECK(first.frames == std::vector<int>{0, 1});
    CHECK(first.frameTimes == std::vector<int>{0, 6});
    CHECK(first.rotation == turned);
    CHECK(first.translation == Vec3i(-3, 5, 7));
    CHECK(first.hidden);
    CHECK(first.layer == 2);
}

TEST_CASE("write vox: an instance placed by its corner lands where it was, for every rotation") {
    for (int bits = 0; bits < 8; ++bits) {
        Scene scene = oneVoxelScene();
        Mat3i rotation = Mat3i::Zero();
        for (int row = 0; row < 3; ++row) rotation(row, (row + 1) % 3) = bits >> row & 1 ? -1 : 1;
        scene.instances[0].rotation = rotation;
        scene.instances[0].centered = false;
        scene.instances[0].translation = Vec3i(-7, 2, 11);
        const auto placed = mergeScene(scene, {}, {});
        const auto read = mergeScene(writtenAndRead(scene), {}, {});
        REQUIRE(placed);
        REQUIRE(read);
        CAPTURE(bits);
        CHECK(read->origin == placed->origin);
    }
}

TEST_CASE("reject: scenes that the format cannot hold") {
    CHECK(writeVox(Scene{}).error().code == ErrorCode::emptyGrid);
    Scene large = oneVoxelScene();
    large.models.emplace_back(Vec3i(1, 257, 1));
    CHECK(writeVox(large).error().code == ErrorCode::tooLarge);
    Scene colorful = oneVoxelScene();
    colorful.materials.resize(256);
    CHECK(writeVox(colorful));
    colorful.materials.resize(257);
    CHECK(writeVox(colorful).error().code == ErrorCode::tooManyLabels);
}

TEST_SUITE_END();
