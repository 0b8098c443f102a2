#include "core/formats/read_npy.h"

#include <doctest/doctest.h>

#include <set>
#include <string>
#include <vector>

#include "core/formats/label_volume.h"
#include "tests/support/npy_builder.h"

using namespace rivage::core;
using rivage::test::NpyFile;
using rivage::test::VoxBuilder;

namespace {

Result<Scene> read(const NpyFile& file, const Limits& limits = {}) {
    return readNpy(file.bytes(), {.limits = limits});
}

std::vector<std::int64_t> ramp(int count) {
    std::vector<std::int64_t> values;
    for (int i = 0; i < count; ++i) values.push_back(i);
    return values;
}

void checkRefused(const NpyFile& file, ErrorCode code, const Limits& limits = {}) {
    const auto scene = read(file, limits);
    REQUIRE_FALSE(scene);
    CHECK(scene.error().code == code);
    CHECK_FALSE(scene.error().message.empty());
}

/// A file with this text as its header and `bytes` zero bytes behind it.
std::vector<std::byte> withHeader(const std::string& header, std::size_t bytes) {
    std::string text = "\x93NUMPY";
    text += {1, 0, static_cast<char>(header.size() & 0xff), static_cast<char>(header.size() >> 8)};
    return VoxBuilder::toBytes(text + header + std::string(bytes, '\1'));
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("read npy: every integer type in both byte orders") {
    for (const std::string kind : {"u", "i"})
        for (const char width : {'1', '2', '4', '8'})
            for (const char order : {'<', '>'}) {
                NpyFile file{.descr = std::string(1, order) + kind + width, .values = ramp(24)};
                if (width == '1') file.descr[0] = '|';
                if (width != '1') file.values[5] = 300;
                CAPTURE(file.descr);
                const auto scene = read(file);
                REQUIRE(scene);
                const BrickGrid& grid = scene->models.at(0);
                CHECK(grid.size() == Vec3i(4, 3, 2));
                for (int i = 0; i < 24; ++i) {
                    const Vec3i voxel(i % 4, i / 4 % 3, i / 12);
                    CHECK(scene->materials[grid.at(voxel)].source ==
                          static_cast<std::uint32_t>(file.values[static_cast<std::size_t>(i)] *
                                                     (i == 0 ? 0 : 1)));
                }
                CHECK(scene->formatDetail == "npy 1 " + file.descr);
            }
}

TEST_CASE("read npy: booleans, where every value but 0 is set") {
    NpyFile file{.descr = "|b1", .values = std::vector<std::int64_t>(24, 0)};
    file.values[3] = 1;
    file.values[4] = 2;
    const auto scene = read(file);
    REQUIRE(scene);
    CHECK(scene->models[0].countVoxels() == 2);
    CHECK(scene->materials.size() == 2);
}

TEST_CASE("read npy: in Fortran order the first axis is x, and x is the fastest either way") {
    const auto c = read({.shape = "(2, 3, 4)", .values = ramp(24)});
    const auto fortran = read({.fortranOrder = true, .shape = "(4, 3, 2)", .values = ramp(24)});
    REQUIRE(c);
    REQUIRE(fortran);
    CHECK(fortran->models[0].size() == Vec3i(4, 3, 2));
    CHECK(c->models[0].at(Vec3i(1, 2, 0)) == MaterialId{9});
    fortran->models[0].forEach([&](const Vec3i& voxel, MaterialId material) {
        CHECK(c->models[0].at(voxel) == material);
    });
}

TEST_CASE("read npy: versions 2 and 3") {
    for (const int version : {2, 3}) {
        NpyFile file{.version = version, .values = ramp(24)};
        CHECK(read(file));
    }
    checkRefused({.version = 4, .values = ramp(24)}, ErrorCode::unsupportedFormat);
    checkRefused({.version = 0, .values = ramp(24)}, ErrorCode::unsupportedFormat);
}

TEST_CASE("read npy: materials are the values in ascending order") {
    NpyFile file{.descr = "<u4", .shape = "(1, 1, 5)", .values = {4000000000, 7, 0, 70000, 7}};
    const auto scene = read(file);
    REQUIRE(scene);
    REQUIRE(scene->materials.size() == 4);
    CHECK(scene->materials[MaterialId{1}].source == 7);
    CHECK(scene->materials[MaterialId{2}].source == 70000);
    CHECK(scene->materials[MaterialId{3}].source == 4000000000);
    CHECK(scene->models[0].at(Vec3i(0, 0, 0)) == MaterialId{3});
    CHECK(scene->models[0].at(Vec3i(2, 0, 0)) == MaterialId{0});
    CHECK(scene->models[0].at(Vec3i(4, 0, 0)) == MaterialId{1});
}

TEST_CASE("read npy: a value has one colour, whatever else the volume holds") {
    CHECK(valueColor(3) == valueColor(3));
    std::set<Rgba8> colors;
    for (std::uint32_t value = 1; value <= 64; ++value) colors.insert(valueColor(value));
    CHECK(colors.size() == 64);
    const auto scene = read({.shape = "(1, 1, 2)", .values = {9, 3}});
    REQUIRE(scene);
    CHECK(scene->materials[MaterialId{1}].color == valueColor(3));
}

TEST_CASE("reject: negative values and values above 32 bits") {
    checkRefused({.descr = "|i1", .shape = "(1, 1, 2)", .values = {1, -1}},
                 ErrorCode::malformedInput);
    checkRefused({.descr = ">i8", .shape = "(1, 1, 2)", .values = {1, -1}},
                 ErrorCode::malformedInput);
    checkRefused({.descr = "<u8", .shape = "(1, 1, 2)", .values = {1, 4294967296}},
                 ErrorCode::malformedInput);
    CHECK(read({.descr = "<u8", .shape = "(1, 1, 2)", .values = {1, 4294967295}}));
}

TEST_CASE("reject: more values than materials, and the limit itself") {
    const NpyFile file{.shape = "(1, 1, 5)", .values = {0, 1, 2, 3, 4}};
    CHECK(read(file, {.maxMaterials = 4}));
    checkRefused(file, ErrorCode::tooManyLabels, {.maxMaterials = 3});
    NpyFile every{.descr = "<u2", .shape = "(16, 64, 64)", .values = ramp(65536)};
    CHECK(read(every));
    every.descr = "<u4";
    every.values[0] = 65536;
    checkRefused(every, ErrorCode::tooManyLabels);
}

TEST_CASE("reject: types that hold no labels, and other numbers of axes") {
    for (const std::string descr :
         {"<f4", "<f8", "<c8", "|S1", "|O1", "<u3", "|u2", "u1", "", "<m8"})
        CHECK(readNpy(withHeader("{'descr': '" + descr +
                                     "', 'fortran_order': False, 'shape': (1, 1, 1)}\n",
                                 1),
                      {})
                  .error()
                  .code == ErrorCode::unsupportedFormat);
    for (const std::string shape : {"()", "(4,)", "(2, 2)", "(1, 1, 2, 2)"})
        checkRefused({.shape = shape, .values = {1, 2, 3, 4}}, ErrorCode::unsupportedFormat);
    CHECK(readNpy(withHeader(
                      "{'descr': [('a', '<u1')], 'fortran_order': False, 'shape': (1, 1, 1)}", 1),
                  {})
              .error()
              .code == ErrorCode::unsupportedFormat);
}

TEST_CASE("reject: headers that are no such dictionary") {
    for (const std::string header :
         {"", "{", "{}", "[1]", "{'descr': '|u1'}", "{'descr': '|u1', 'shape': (1, 1, 1)}",
          "{'descr': |u1, 'fortran_order': False, 'shape': (1, 1, 1)}",
          "{'descr': '|u1' 'fortran_order': False, 'shape': (1, 1, 1)}",
          "{'descr': '|u1', 'fortran_order': Maybe, 'shape': (1, 1, 1)}",
          "{'descr': '|u1', 'fortran_order': False, 'shape': (1, 1, 1}",
          "{'descr': '|u1', 'fortran_order': False, 'shape': (1, -1, 1)}",
          "{'descr': '|u1', 'fortran_order': False, 'shape': (1, 1, 1), 'more': 1}",
          "{'descr': '|u1', 'fortran_order': False, 'shape': (1, 1, 1)} x"}) {
        CAPTURE(header);
        const auto scene = readNpy(withHeader(header, 1), {});
        REQUIRE_FALSE(scene);
        CHECK(scene.error().code == ErrorCode::malformedInput);
    }
}

TEST_CASE("reject: every proper prefix, and a byte behind the values") {
    const auto whole = NpyFile{.descr = "<u2", .values = ramp(24)}.bytes();
    REQUIRE(readNpy(whole, {}));
    for (std::size_t length = 0; length < whole.size(); ++length) {
        CAPTURE(length);
        const std::vector<std::byte> prefix(whole.begin(), whole.begin() + length);
        const auto scene = readNpy(prefix, {});
        REQUIRE_FALSE(scene);
        CHECK(scene.error().code == ErrorCode::malformedInput);
    }
    std::vector<std::byte> longer = whole;
    longer.push_back(std::byte{0});
    CHECK_FALSE(readNpy(longer, {}));
}

TEST_CASE("reject: shapes of 0, of 10 GB and beyond 64 bits, before anything is allocated") {
    checkRefused({.shape = "(0, 3, 4)"}, ErrorCode::malformedInput);
    checkRefused({.shape = "(2000, 2500, 2000)"}, ErrorCode::tooLarge);
    checkRefused({.shape = "(4294967296, 4294967296, 4294967296)"}, ErrorCode::tooLarge);
    checkRefused({.shape = "(18446744073709551615, 1, 1)"}, ErrorCode::tooLarge);
    checkRefused({.shape = "(99999999999999999999, 1, 1)"}, ErrorCode::malformedInput);
    checkRefused({.shape = "(1, 1, 5000)", .values = ramp(5000)}, ErrorCode::tooLarge);
}

TEST_CASE("reject: a volume of zeros only") {
    checkRefused({.shape = "(1, 1, 2)", .values = {0, 0}}, ErrorCode::emptyGrid);
}

TEST_SUITE_END();
