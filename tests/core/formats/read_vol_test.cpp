#include "core/formats/read_vol.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/packed.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::packed;
using rivage::test::VoxBuilder;

namespace {

const std::string kValues{"\0\1\2\3\0\5", 6};  // 3 x 1 x 2

/// A header with the lines that differ put in; later ones win.
std::string headerWith(const std::string& lines) {
    return "Center-X: 1\nX: 3\nY: 1\nZ: 2\nVoxel-Size: 1\nAlpha-Color: 0\nInt-Endian: 0123\n"
           "Voxel-Endian: 0\nRes-X: 1.000000\n" +
           lines + ".\n";
}

Result<Scene> read(const std::string& bytes) { return readVol(VoxBuilder::toBytes(bytes), {}); }

std::uint32_t valueAt(const Scene& scene, int x, int y, int z) {
    return scene.materials[scene.models[0].at(Vec3i(x, y, z))].source;
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("read vol: without version, version 2, and packed as version 3") {
    const std::string sizes{"\3\0\0\0\1\0\0\0\2\0\0\0\n", 13};
    for (const std::string& file :
         {headerWith("") + sizes + kValues, headerWith("Version: 2\n") + kValues,
          headerWith("Version: 3\n") + packed(kValues, false)}) {
        CAPTURE(file);
        CHECK(isVol(VoxBuilder::toBytes(file)));
        const auto scene = read(file);
        REQUIRE_MESSAGE(scene, (scene ? "" : scene.error().message));
        CHECK(scene->models[0].size() == Vec3i(3, 1, 2));
        CHECK(valueAt(*scene, 1, 0, 0) == 1);
        CHECK(valueAt(*scene, 2, 0, 1) == 5);
        CHECK(scene->format == GridFormat::vol);
    }
    CHECK(read(headerWith("Version: 3\n") + packed(kValues, false))->formatDetail == "vol 3");
}

TEST_CASE("read vol: values of 8 bytes, as in .longvol") {
    const std::string lines = "Lvoxel-Size: 8\nX: 2\nZ: 1\nVersion: 2\n";
    const std::string little{"\1\2\0\0\0\0\0\0\7\0\0\0\0\0\0\0", 16};
    const auto scene = read(headerWith(lines) + little);
    REQUIRE(scene);
    CHECK(valueAt(*scene, 0, 0, 0) == 0x201);
    CHECK(valueAt(*scene, 1, 0, 0) == 7);
    const std::string big{"\0\0\0\0\0\0\2\1\0\0\0\0\0\0\0\7", 16};
    const auto other = read(headerWith(lines + "Int-Endian: 3210\n") + big);
    REQUIRE(other);
    CHECK(valueAt(*other, 0, 0, 0) == 0x201);
}

TEST_CASE("reject: .vol files that are broken") {
    for (const std::string& file :
         {std::string("X: 1\n.\n"), headerWith("X: three\n") + kValues,
          headerWith("X: 0\nVersion: 2\n"), headerWith("Version: 2\n") + kValues + "x",
          headerWith("Version: 2\n") + "x", headerWith("Version: 3\n") + kValues,
          headerWith("Version: 3\n") + packed(kValues + "x"),
          headerWith("Version: 3\n") + packed("x"), headerWith("") + kValues, headerWith(""),
          headerWith("Voxel-Size: big\nVersion: 2\n") + kValues}) {
        CAPTURE(file);
        const auto scene = read(file);
        REQUIRE_FALSE(scene);
        CHECK(scene.error().code == ErrorCode::malformedInput);
        CHECK(scene.error().field.starts_with("/grid"));
    }
    CHECK(read(headerWith("Version: 4\n") + kValues).error().code == ErrorCode::unsupportedFormat);
    CHECK(read(headerWith("Voxel-Size: 3\nVersion: 2\n") + kValues).error().code ==
          ErrorCode::unsupportedFormat);
    CHECK_FALSE(isVol(VoxBuilder::toBytes("Voxel-Size: 1\n.\n")));
    CHECK_FALSE(isVol(VoxBuilder::toBytes(headerWith(std::string(5000, 'x') + ":\n"))));
}
