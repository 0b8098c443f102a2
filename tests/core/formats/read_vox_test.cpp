#include "core/formats/read_vox.h"

#include <doctest/doctest.h>

#include <cstring>
#include <string>
#include <vector>

#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::smallVox;
using rivage::test::VoxBuilder;

namespace {

Result<Scene> read(const std::vector<std::byte>& bytes, const Limits& limits = {}) {
    return readVox(bytes, {}, {.limits = limits});
}

void checkRefused(const std::vector<std::byte>& bytes, ErrorCode code, const std::string& field,
                  const Limits& limits = {}) {
    const auto scene = read(bytes, limits);
    REQUIRE_FALSE(scene);
    CHECK(scene.error().code == code);
    CHECK(scene.error().field == field);
    CHECK_FALSE(scene.error().message.empty());
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("read vox: voxels, palette and format of a small file") {
    const auto scene = read(smallVox());
    REQUIRE(scene);
    REQUIRE(scene->models.size() == 2);
    CHECK(scene->models[0].size() == Vec3i(2, 3, 1));
    CHECK(scene->models[0].at(Vec3i(0, 0, 0)) == MaterialId{1});
    CHECK(scene->models[0].at(Vec3i(1, 2, 0)) == MaterialId{2});
    CHECK(scene->models[0].countVoxels() == 2);
    CHECK(scene->materials[MaterialId{1}].color == Rgba8{0, 255, 7, 255});
    CHECK(scene->materials[MaterialId{255}].color == Rgba8{254, 1, 7, 255});
    CHECK(scene->format == GridFormat::vox);
    CHECK(scene->formatDetail == "vox 200");
    CHECK_FALSE(scene->laterInstanceWins);
    CHECK(scene->warnings.empty());
}

TEST_CASE("read vox: without a scene graph the models are frames of one instance") {
    const auto scene = read(VoxBuilder(150)
                                .chunk("PACK", VoxBuilder::number(3))
                                .cube(1, 5)
                                .cube(2, 6)
                                .cube(3, 7)
                                .bytes());
    REQUIRE(scene);
    REQUIRE(scene->instances.size() == 1);
    CHECK(scene->instances[0].frames == std::vector<int>{0, 1, 2});
    CHECK(scene->laterInstanceWins);
    CHECK(scene->formatDetail == "vox 150");
}

TEST_CASE("read vox: a PACK count that is wrong is a warning") {
    const auto scene =
        read(VoxBuilder(150).chunk("PACK", VoxBuilder::number(9)).cube(1, 5).bytes());
    REQUIRE(scene);
    CHECK(scene->warnings.size() == 1);
}

TEST_CASE("read vox: a voxel with colour 0 is empty, and of two at one place the later counts") {
    const auto scene =
        read(VoxBuilder().size(2, 1, 1).voxels({{0, 0, 0, 0}, {1, 0, 0, 4}, {1, 0, 0, 5}}).bytes());
    REQUIRE(scene);
    CHECK(scene->models[0].countVoxels() == 1);
    CHECK(scene->models[0].at(Vec3i(1, 0, 0)) == MaterialId{5});
}

TEST_CASE("read vox: unknown chunks are skipped") {
    const auto scene = read(VoxBuilder().chunk("rOBJ", "abc").cube(1, 5).chunk("XXXX", "").bytes());
    REQUIRE(scene);
    CHECK(scene->models.size() == 1);
}

TEST_CASE("reject: every proper prefix of a file") {
    const std::vector<std::byte> whole = smallVox();
    REQUIRE(read(whole));
    for (std::size_t length = 0; length < whole.size(); ++length) {
        CAPTURE(length);
        // An exact copy, so that a sanitizer sees a read behind the end.
        const std::vector<std::byte> prefix(whole.begin(), whole.begin() + length);
        const auto scene = read(prefix);
        REQUIRE_FALSE(scene);
        CHECK(scene.error().code == ErrorCode::malformedInput);
    }
}

TEST_CASE("reject: bytes behind the end of MAIN") {
    std::vector<std::byte> bytes = smallVox();
    bytes.push_back(std::byte{0});
    checkRefused(bytes, ErrorCode::malformedInput, "/grid");
}

TEST_CASE("reject: each byte of a small file set to 255 is refused or read, never a crash") {
    const std::vector<std::byte> whole = smallVox();
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::vector<std::byte> broken = whole;
        broken[i] = std::byte{0xff};
        const auto scene = read(broken);
        CHECK((scene || !scene.error().message.empty()));
    }
}

TEST_CASE("reject: sizes of 0, 257 and 2^31") {
    for (const std::uint32_t side : {0U, 257U, 0x80000000U, 0xffffffffU}) {
        CAPTURE(side);
        const auto bytes = VoxBuilder().size(1, side, 1).voxels({}).bytes();
        checkRefused(bytes, ErrorCode::malformedInput, "/grid/models/0/size");
        const auto scene = read(bytes);
        CHECK(scene.error().limit == 256);
        CHECK(scene.error().actual == side);
    }
}

TEST_CASE("reject: a voxel outside its model") {
    checkRefused(VoxBuilder().cube(1, 1).size(2, 2, 2).voxels({{0, 0, 0, 1}, {2, 0, 0, 1}}).bytes(),
                 ErrorCode::malformedInput, "/grid/models/1/voxels");
}

TEST_CASE("reject: a voxel count beyond its chunk, or below it") {
    for (const std::uint32_t count : {2U, 0U, 0x40000001U, 0xffffffffU}) {
        CAPTURE(count);
        const std::string content = VoxBuilder::number(count) + std::string(4, '\1');
        checkRefused(VoxBuilder().size(2, 2, 2).chunk("XYZI", content).bytes(),
                     ErrorCode::malformedInput, "/grid/models/0/voxels");
    }
}

TEST_CASE("reject: SIZE and XYZI that do not alternate") {
    checkRefused(VoxBuilder().voxels({}).bytes(), ErrorCode::malformedInput, "/grid/models/0");
    checkRefused(VoxBuilder().cube(1, 1).size(1, 1, 1).bytes(), ErrorCode::malformedInput,
                 "/grid/models/1");
    checkRefused(VoxBuilder().size(1, 1, 1).size(1, 1, 1).bytes(), ErrorCode::malformedInput,
                 "/grid/models/0");
}

TEST_CASE("reject: a chunk that ends after its parent") {
    std::vector<std::byte> bytes = VoxBuilder().cube(1, 1).bytes();
    for (const std::size_t at : {24U, 28U}) {  // content and child bytes of the SIZE chunk
        std::vector<std::byte> broken = bytes;
        broken[at + 3] = std::byte{0x7f};
        checkRefused(broken, ErrorCode::malformedInput, "/grid");
        CHECK(read(broken).error().actual.value_or(0) > 0x7e000000);
    }
}

TEST_CASE("reject: versions other than 150 and 200") {
    for (const int version : {0, 149, 151, 199, 201, -1})
        checkRefused(VoxBuilder(version).cube(1, 1).bytes(), ErrorCode::unsupportedFormat,
                     "/grid/version");
}

TEST_CASE("reject: no model at all") {
    checkRefused(VoxBuilder().bytes(), ErrorCode::emptyGrid, "/grid/models");
}

TEST_CASE("reject: more models than the limit") {
    const auto bytes = VoxBuilder().cube(1, 1).cube(1, 1).cube(1, 1).bytes();
    CHECK(read(bytes, {.maxModels = 3}));
    checkRefused(bytes, ErrorCode::tooLarge, "/grid/models", {.maxModels = 2});
}

TEST_CASE("reject: models that would not fit the memory budget") {
    // 4096 voxels, each in a brick of its own: 16 kB of file ask for 32 MB of bricks.
    std::vector<VoxBuilder::Voxel> voxels;
    for (int z = 0; z < 256; z += 16)
        for (int y = 0; y < 256; y += 16)
            for (int x = 0; x < 256; x += 16) voxels.push_back({x, y, z, 1});
    const auto bytes = VoxBuilder().size(256, 256, 256).voxels(voxels).bytes();
    CHECK(read(bytes));
    checkRefused(bytes, ErrorCode::memoryBudget, "/grid/models", {.maxMemory = 16 << 20});
}

TEST_CASE("reject: palette chunks of the wrong length") {
    checkRefused(VoxBuilder().cube(1, 1).chunk("RGBA", std::string(1023, 'x')).bytes(),
                 ErrorCode::malformedInput, "/grid/palette");
    checkRefused(VoxBuilder().cube(1, 1).chunk("IMAP", std::string(1024, 'x')).bytes(),
                 ErrorCode::malformedInput, "/grid/palette/order");
    checkRefused(VoxBuilder().cube(1, 1).chunk("IMAP", std::string(256, 'x')).bytes(),
                 ErrorCode::malformedInput, "/grid/palette/order");
}

TEST_CASE("reject: dictionaries with huge counts and strings") {
    const std::string big = VoxBuilder::number(0xffffffff);
    checkRefused(VoxBuilder().cube(1, 1).chunk("MATL", VoxBuilder::number(1) + big).bytes(),
                 ErrorCode::malformedInput, "/grid/materials");
    checkRefused(VoxBuilder()
                     .cube(1, 1)
                     .chunk("LAYR", VoxBuilder::number(1) + VoxBuilder::number(1) + big)
                     .bytes(),
                 ErrorCode::malformedInput, "/grid/layers");
    checkRefused(VoxBuilder().cube(1, 1).chunk("NOTE", big).bytes(), ErrorCode::malformedInput,
                 "/grid/palette/notes");
    checkRefused(VoxBuilder().cube(1, 1).chunk("MATT", VoxBuilder::number(1)).bytes(),
                 ErrorCode::malformedInput, "/grid/materials");
}

TEST_CASE("read vox: gives up when asked to") {
    RunContext run;
    run.stopRequested = [] { return true; };
    const auto scene = readVox(smallVox(), {}, run);
    REQUIRE_FALSE(scene);
    CHECK(scene.error().code == ErrorCode::cancelled);
}

TEST_SUITE_END();
