#include "core/formats/read_raw.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/vox_builder.h"

using namespace rivage::core;

namespace {

Result<Scene> read(const std::string& bytes, const InputOptions& options,
                   const Limits& limits = {}) {
    return readRaw(rivage::test::VoxBuilder::toBytes(bytes), options, {.limits = limits});
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("read raw: bytes, x fastest") {
    const auto scene = read({"\1\2\0\4\5\6", 6}, {.dims = Vec3i(3, 1, 2)});
    REQUIRE(scene);
    CHECK(scene->models[0].size() == Vec3i(3, 1, 2));
    CHECK(scene->materials[scene->models[0].at(Vec3i(1, 0, 0))].source == 2);
    CHECK(scene->materials[scene->models[0].at(Vec3i(0, 0, 1))].source == 4);
    CHECK(scene->format == GridFormat::raw);
    CHECK(scene->formatDetail == "raw u8");
}

TEST_CASE("read raw: 16 bits, little-endian") {
    const auto scene = read({"\1\2\0\4", 4}, {.dims = Vec3i(2, 1, 1), .rawType = RawType::u16});
    REQUIRE(scene);
    CHECK(scene->materials[scene->models[0].at(Vec3i(0, 0, 0))].source == 0x201);
    CHECK(scene->materials[scene->models[0].at(Vec3i(1, 0, 0))].source == 0x400);
}

TEST_CASE("reject: no dims, dims below 1") {
    const auto without = read("\1", {});
    REQUIRE_FALSE(without);
    CHECK(without.error().code == ErrorCode::invalidOption);
    CHECK(without.error().field == "/options/dims");
    for (const Vec3i& dims : {Vec3i(0, 1, 1), Vec3i(1, -1, 1), Vec3i(-1, -1, 1)})
        CHECK(read("\1", {.dims = dims}).error().code == ErrorCode::invalidOption);
}

TEST_CASE("reject: a byte count that does not match dims") {
    for (const std::string bytes : {"\1\2\3", "\1\2\3\4\5", ""}) {
        const auto scene = read(bytes, {.dims = Vec3i(2, 2, 1)});
        REQUIRE_FALSE(scene);
        CHECK(scene.error().code == ErrorCode::malformedInput);
        CHECK(scene.error().limit == 4);
        CHECK(scene.error().actual == bytes.size());
    }
}

TEST_CASE("reject: 10 GB of dims, and dims whose product leaves 64 bits") {
    const auto large = read("\1", {.dims = Vec3i(2000, 2500, 2000)});
    REQUIRE_FALSE(large);
    CHECK(large.error().code == ErrorCode::tooLarge);
    CHECK(large.error().field == "/options/dims");
    CHECK(large.error().actual == 10000000000);
    CHECK(read("\1", {.dims = Vec3i::Constant(0x7fffffff)}).error().code == ErrorCode::tooLarge);
    CHECK(read(std::string(5000, '\1'), {.dims = Vec3i(5000, 1, 1)}).error().code ==
          ErrorCode::tooLarge);
}

TEST_CASE("reject: a flat volume whose bricks exceed the memory budget") {
    const std::string bytes(64 * 64, '\1');
    CHECK(read(bytes, {.dims = Vec3i(64, 64, 1)}));
    CHECK(read(bytes, {.dims = Vec3i(64, 64, 1)}, {.maxMemory = 100000}).error().code ==
          ErrorCode::memoryBudget);
}

TEST_SUITE_END();
