#include "core/formats/read_scene.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/npy_builder.h"
#include "tests/support/packed.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::NpyFile;
using rivage::test::packed;
using rivage::test::smallVox;
using rivage::test::VoxBuilder;

namespace {

Error errorOf(const std::string& bytes, const InputOptions& options = {}) {
    const auto scene = readScene(VoxBuilder::toBytes(bytes), options, {});
    REQUIRE_FALSE(scene);
    return scene.error();
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("read scene: finds the format by the first bytes") {
    const auto vox = readScene(smallVox(), {}, {});
    REQUIRE(vox);
    CHECK(vox->format == GridFormat::vox);
    const auto npy = readScene(NpyFile{.shape = "(1, 1, 2)", .values = {1, 2}}.bytes(), {}, {});
    REQUIRE(npy);
    CHECK(npy->format == GridFormat::npy);
    const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\n\1";
    CHECK(readScene(VoxBuilder::toBytes(nrrd), {}, {})->format == GridFormat::nrrd);
    const std::string vol = "X: 1\nY: 1\nZ: 1\nVoxel-Size: 1\nVersion: 2\n.\n\1";
    CHECK(readScene(VoxBuilder::toBytes(vol), {}, {})->format == GridFormat::vol);
    CHECK(errorOf(std::string("\0\0\1\x5c", 4) + std::string(340, '\0') + "n+1").code ==
          ErrorCode::unsupportedFormat);  // too short by a byte
    CHECK(errorOf(std::string("\0\0\1\x5c", 4) + std::string(340, '\0') + "n+1" + '\0').field ==
          "/grid/header/datatype");
}

TEST_CASE("read scene: what is packed by gzip is unpacked, but for raw") {
    const auto vox = smallVox();
    const std::string text(reinterpret_cast<const char*>(vox.data()), vox.size());
    const auto bytes = VoxBuilder::toBytes(packed(text));
    const auto scene = readScene(bytes, {}, {});
    REQUIRE(scene);
    CHECK(scene->format == GridFormat::vox);
    CHECK(readScene(bytes, {.format = GridFormat::vox}, {}));
    CHECK(readScene(VoxBuilder::toBytes(packed("\1\2")),
                    {.format = GridFormat::raw,
                     .dims = Vec3i(static_cast<int>(packed("\1\2").size()), 1, 1)},
                    {}));
    CHECK(errorOf(packed(packed(text))).message.find("gzip data in gzip") != std::string::npos);
    CHECK(errorOf(packed("hello")).code == ErrorCode::unsupportedFormat);
    const Limits limits{.maxInputBytes = text.size() - 1};
    const auto large = readScene(bytes, {}, {.limits = limits});
    REQUIRE_FALSE(large);
    CHECK(large.error().code == ErrorCode::tooLarge);
    CHECK(large.error().setting == "--max-upload");
}

TEST_CASE("read scene: the format that was asked for wins") {
    CHECK(readScene(VoxBuilder::toBytes("VOX "),
                    {.format = GridFormat::raw, .dims = Vec3i(4, 1, 1)}, {}));
    const auto wrong = readScene(smallVox(), {.format = GridFormat::npy}, {});
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().code == ErrorCode::malformedInput);
    CHECK(errorOf("abc", {.format = GridFormat::vox}).code == ErrorCode::malformedInput);
}

TEST_CASE("reject: unknown bytes, naming the formats that are read") {
    const Error error = errorOf("hello");
    CHECK(error.code == ErrorCode::unsupportedFormat);
    CHECK(error.message.find(".vox") != std::string::npos);
    CHECK(error.message.find(".npy") != std::string::npos);
    CHECK(error.message.find(".nrrd") != std::string::npos);
    CHECK(error.message.find("dims") != std::string::npos);
    CHECK(errorOf("").code == ErrorCode::malformedInput);
}

TEST_CASE("reject: formats that are often sent by mistake, with advice") {
    CHECK(errorOf("\x1f\x8b\x08").code == ErrorCode::malformedInput);
    CHECK(errorOf("\x28\xb5\x2f\xfd").message.find("zstd") != std::string::npos);
    CHECK(errorOf("PK\x03\x04").message.find("ZIP") != std::string::npos);
    CHECK(errorOf("glTF").message.find("mesh") != std::string::npos);
    CHECK(errorOf("{\"a\": 1}").message.find("JSON") != std::string::npos);
}

TEST_CASE("reject: more bytes than the limit") {
    const std::vector<std::byte> bytes = smallVox();
    CHECK(readScene(bytes, {}, {.limits = {.maxInputBytes = bytes.size()}}));
    const auto scene = readScene(bytes, {}, {.limits = {.maxInputBytes = bytes.size() - 1}});
    REQUIRE_FALSE(scene);
    CHECK(scene.error().code == ErrorCode::tooLarge);
    CHECK(scene.error().actual == bytes.size());
}

TEST_SUITE_END();
