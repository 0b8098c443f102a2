#include "core/formats/read_scene.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/npy_builder.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::NpyFile;
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
    CHECK(error.message.find("dims") != std::string::npos);
    CHECK(errorOf("").code == ErrorCode::malformedInput);
}

TEST_CASE("reject: formats that are often sent by mistake, with advice") {
    CHECK(errorOf("\x1f\x8b\x08").message.find("gzip") != std::string::npos);
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
