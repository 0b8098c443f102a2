#include "core/formats/read_nrrd.h"

#include <doctest/doctest.h>

#include <string>

#include "core/formats/label_volume.h"
#include "core/formats/write_nrrd.h"
#include "core/grid/scene.h"
#include "tests/support/packed.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::packed;
using rivage::test::VoxBuilder;

namespace {

const std::string kValues{"\0\1\2\3\0\5", 6};  // 3 x 1 x 2

/// A header with the fields that differ put in; later ones win.
std::string headerWith(const std::string& fields) {
    return "NRRD0004\n# a comment\ntype: uint8\ndimension: 3\nsizes: 3 1 2\nencoding: raw\n" +
           fields + "\n";
}

Result<Scene> read(const std::string& bytes, const Limits& limits = {}) {
    return readNrrd(VoxBuilder::toBytes(bytes), {.limits = limits});
}

Scene sceneOf(const std::string& bytes) {
    auto scene = read(bytes);
    REQUIRE_MESSAGE(scene, (scene ? "" : scene.error().message));
    return *std::move(scene);
}

std::uint32_t valueAt(const Scene& scene, int x, int y, int z) {
    return scene.materials[scene.models[0].at(Vec3i(x, y, z))].source;
}

Error errorOf(const std::string& bytes, const Limits& limits = {}) {
    const auto scene = read(bytes, limits);
    REQUIRE_FALSE(scene);
    CHECK(scene.error().field.starts_with("/grid"));
    return scene.error();
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("read nrrd: raw bytes, x fastest") {
    const Scene scene = sceneOf(headerWith("") + kValues);
    CHECK(scene.models[0].size() == Vec3i(3, 1, 2));
    CHECK(valueAt(scene, 1, 0, 0) == 1);
    CHECK(valueAt(scene, 0, 0, 1) == 3);
    CHECK(valueAt(scene, 2, 0, 1) == 5);
    CHECK(scene.models[0].at(Vec3i(1, 0, 1)) == MaterialId{0});
    CHECK(scene.format == GridFormat::nrrd);
    CHECK(scene.formatDetail == "nrrd 4 uint8");
    CHECK(scene.spacing == Vec3d::Ones());
    CHECK(scene.warnings.empty());
}

TEST_CASE("read nrrd: encodings, line ends, skips") {
    for (const std::string& file :
         {headerWith("encoding: gzip\n") + packed(kValues),
          headerWith("ENCODING: GZ\n") + packed(kValues),
          headerWith("encoding: gzip\nbyte skip: 4\n") + packed("skip" + kValues),
          headerWith("encoding: gzip\nline skip: 1\n") + "a line\n" + packed(kValues),
          headerWith("encoding: ascii\n") + "0 1,2\n3\t0\r\n5\n",
          headerWith("encoding: txt\ntype: double\n") + " 0 1 2 3 0 5",
          headerWith("line skip: 2\nbyte skip: 1\n") + "one\ntwo\n." + kValues,
          headerWith("byte skip: -1\n") + "whatever stands here" + kValues,
          "NRRD0005\r\ntype: uchar\r\ndimension: 3\r\nsizes: 3  1 2\r\nencoding:raw\r\n\r\n" +
              kValues}) {
        CAPTURE(file);
        const Scene scene = sceneOf(file);
        CHECK(valueAt(scene, 2, 0, 0) == 2);
        CHECK(valueAt(scene, 2, 0, 1) == 5);
    }
}

TEST_CASE("read nrrd: every type, both byte orders") {
    struct Case {
        const char* type;
        std::string one;  ///< 1, little-endian
    };
    for (const Case& of :
         {Case{"signed char", "\1"}, Case{"unsigned char", "\1"}, Case{"short", {"\1\0", 2}},
          Case{"unsigned short int", {"\1\0", 2}}, Case{"int", {"\1\0\0\0", 4}},
          Case{"uint32_t", {"\1\0\0\0", 4}}, Case{"long long int", {"\1\0\0\0\0\0\0\0", 8}},
          Case{"uint64", {"\1\0\0\0\0\0\0\0", 8}}, Case{"float", {"\0\0\x80\x3f", 4}},
          Case{"double", {"\0\0\0\0\0\0\xf0\x3f", 8}}})
        for (const bool big : {false, true}) {
            CAPTURE(of.type);
            const std::string zero(of.one.size(), '\0');
            const std::string one = big ? std::string(of.one.rbegin(), of.one.rend()) : of.one;
            const Scene scene = sceneOf(headerWith("sizes: 2 1 1\ntype: " + std::string(of.type) +
                                                   "\nendian: " + (big ? "big\n" : "little\n")) +
                                        zero + one);
            CHECK(valueAt(scene, 1, 0, 0) == 1);
            CHECK(scene.models[0].countVoxels() == 1);
        }
}

TEST_CASE("read nrrd: segments of 3D Slicer name and colour their values") {
    const Scene scene = sceneOf(
        headerWith("Segment0_Name:=lung, left\nSegment0_Color:=1 0.5 0\nSegment0_LabelValue:=5\n"
                   "Segment0_Layer:=0\nSegment1_Name:=a\\nb\\\\c\nSegment1_LabelValue:=2\n"
                   "Segment1_Color:=2 2 2\nSegment2_Name:=third\nSegmentation_Source:=x\n"
                   "Segment9_LabelValue:=77\n") +
        kValues);
    const auto materialOf = [&](std::uint32_t value) {
        for (const Material& material : scene.materials.raw())
            if (material.source == value) return material;
        return Material{};
    };
    CHECK(materialOf(5).name == "lung, left");
    CHECK(materialOf(5).color == Rgba8{255, 128, 0, 255});
    CHECK(materialOf(2).name == "a b\\c");
    CHECK(materialOf(3).name == "third");  // no value: the number after that of the segment
    CHECK(materialOf(1).name.empty());
    CHECK(materialOf(1).color == valueColor(1));
    CHECK(materialOf(2).color == valueColor(2));
}

TEST_CASE("read nrrd: axes and sides of a voxel") {
    const auto placed = [](const std::string& fields) {
        return sceneOf(headerWith(fields) + kValues);
    };
    CHECK(placed("spacings: 1 1 2.5\n").spacing == Vec3d(1, 1, 2.5));
    CHECK(placed("spacings: 1 nan 2\n").spacing == Vec3d(1, 1, 2));
    const Scene lps =
        placed("space: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,2)\n");
    CHECK(lps.spacing == Vec3d(1, 1, 4));
    CHECK(lps.instances[0].rotation == Mat3i(Vec3i(-1, -1, 1).asDiagonal()));
    CHECK(lps.warnings.empty());
    const Scene ras = placed("space: RAS\nspace directions: (0, 0, 3) (1,0,0) (0,-2,0)\n");
    Mat3i turned;
    turned << 0, 1, 0, 0, 0, -1, 1, 0, 0;
    CHECK(ras.instances[0].rotation == turned);
    CHECK(ras.spacing == Vec3d(1, 2, 3));
    const Scene oblique = placed("space directions: (0.98,0.17,0) (-0.17,0.98,0) (0,0,1)\n");
    CHECK(oblique.instances[0].rotation == Mat3i::Identity());
    REQUIRE(oblique.warnings.size() == 1);
    CHECK(oblique.warnings[0].find("9.8 degrees") != std::string::npos);
}

TEST_CASE("read nrrd: what this project writes comes back, with the names of its labels") {
    VoxelGrid grid;
    grid.voxels = BrickGrid(Vec3i(4, 3, 2));
    grid.labels.push_back("sea");
    grid.labels.push_back("land\\n of hope");
    grid.materials.push_back({.label = Label{1}, .color = {0, 0, 255, 255}});
    grid.materials.push_back({.label = Label{2}, .color = {10, 200, 30, 255}});
    grid.voxels.set(Vec3i(3, 2, 1), MaterialId{2});
    grid.voxels.set(Vec3i(0, 1, 0), MaterialId{1});
    for (const bool gzip : {false, true}) {
        const auto bytes = writeNrrd(grid, {.spacing = Vec3d(1, 2, 4)}, gzip, {});
        REQUIRE(bytes);
        const auto scene = readNrrd(*bytes, {});
        REQUIRE(scene);
        CHECK(scene->spacing == Vec3d(1, 2, 4));
        CHECK(scene->instances[0].rotation == Mat3i::Identity());
        const Material& land = scene->materials[scene->models[0].at(Vec3i(3, 2, 1))];
        CHECK(land.name == "land\\n of hope");
        CHECK(land.color == Rgba8{10, 200, 30, 255});
        CHECK(scene->materials[scene->models[0].at(Vec3i(0, 1, 0))].name == "sea");
        CHECK(scene->models[0].countVoxels() == 2);
    }
}

TEST_CASE("reject: NRRD headers that say nothing that can be read") {
    struct Case {
        const char* fields;
        const char* field;
        ErrorCode code;
    };
    constexpr auto kBad = ErrorCode::malformedInput;
    constexpr auto kOther = ErrorCode::unsupportedFormat;
    for (const Case& bad :
         {Case{"type: block\n", "type", kOther},
          Case{"encoding: bzip2\n", "encoding", kOther},
          Case{"encoding: hex\n", "encoding", kOther},
          Case{"type: short\n", "endian", kBad},
          Case{"type: short\nendian: middle\n", "endian", kBad},
          Case{"dimension: 2\nsizes: 3 2\n", "dimension", kOther},
          Case{"dimension: 4\nsizes: 1 3 1 2\n", "dimension", kOther},
          Case{"sizes: 3 1\n", "sizes", kBad},
          Case{"sizes: 3 1 x\n", "sizes", kBad},
          Case{"sizes: 3 1 0\n", "sizes", kBad},
          Case{"sizes: 3 1 -2\n", "sizes", kBad},
          Case{"data file: values.raw\n", "data file", kOther},
          Case{"line skip: -1\n", "line skip", kBad},
          Case{"line skip: 9\n", "line skip", kBad},
          Case{"byte skip: -2\n", "byte skip", kBad},
          Case{"encoding: gzip\nbyte skip: -1\n", "byte skip", kBad},
          Case{"spacings: 1 one 1\n", "spacings", kBad},
          Case{"spacings: 1 0 1\n", "space directions", kBad},
          Case{"spacings: 1 1000 1\n", "space directions", kBad},
          Case{"spacings: 1 inf 1\n", "space directions", kBad},
          Case{"space directions: (1,0,0) (0,1,0)\n", "space directions", kBad},
          Case{"space directions: (1,0,0) (0,1) (0,0,1)\n", "space directions", kBad},
          Case{"space directions: (1,0,0) none (0,0,1)\n", "space directions", kBad},
          Case{"space directions: (1,0,0) (1,0,0) (0,0,1)\n", "space directions", kBad},
          Case{"space directions: (1,0,0) (0,0,0) (0,0,1)\n", "space directions", kBad},
          Case{"Segment1_Layer:=1\n", "segments", kOther}}) {
        CAPTURE(bad.fields);
        const Error error = errorOf(headerWith(bad.fields) + kValues);
        CHECK(error.field == std::string("/grid/header/") + bad.field);
        CHECK(error.code == bad.code);
    }
    for (const char* file : {"NRRD", "NRRD0007\n\n", "NRRD0005", "NRRDxxxx\n\n", "NRRD00055\n\n"})
        CHECK(errorOf(file).code == kOther);
    for (const char* file : {"NRRD0005\n", "NRRD0005\n\n", "NRRD0005\ntype: uint8\n\n",
                             "NRRD0005\nno field\n\n", "NRRD0005\n: x\n\n"})
        CHECK(errorOf(file).code == kBad);
}

TEST_CASE("reject: NRRD values that do not fit the sizes, or are no labels") {
    for (const std::string& file :
         {headerWith("") + kValues.substr(1), headerWith("") + kValues + "x",
          headerWith("byte skip: 7\n") + kValues, headerWith("byte skip: -1\n") + "abc",
          headerWith("encoding: gzip\n") + packed(kValues + "x"),
          headerWith("encoding: gzip\n") + packed("abc"), headerWith("encoding: gzip\n") + "abc",
          headerWith("encoding: gzip\nbyte skip: 9\n") + packed(kValues),
          headerWith("encoding: text\n") + "1 2 3 4 5",
          headerWith("encoding: text\n") + "1 2 3 4 5 6 7",
          headerWith("encoding: text\n") + "1 2 3 4 5 -6",
          headerWith("encoding: text\n") + "1 2 3 4 5 six",
          headerWith("type: float\nendian: little\nsizes: 1 1 1\n") + std::string("\0\0\0\x3f", 4),
          headerWith("type: float\nendian: little\nsizes: 1 1 1\n") +
              std::string("\0\0\xc0\x7f", 4),
          headerWith("type: int8\nsizes: 1 1 1\n") + "\xff"}) {
        CAPTURE(file);
        CHECK(errorOf(file).code == ErrorCode::malformedInput);
    }
    CHECK(errorOf(headerWith("") + std::string(6, '\0')).code == ErrorCode::emptyGrid);
    CHECK(errorOf(headerWith("sizes: 3 1 4000000000\n") + kValues).code == ErrorCode::tooLarge);
    const Error large = errorOf(headerWith("encoding: gzip\nsizes: 300 300 300\n") + packed("x"),
                                {.maxInputBytes = 1 << 20});
    CHECK(large.code == ErrorCode::tooLarge);
    CHECK(large.setting == "--max-upload");
}
