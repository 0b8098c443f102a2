#include "core/formats/read_nifti.h"

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::VoxBuilder;

namespace {

/// A NIfTI file with the fields that matter; shares nothing with the reader.
struct NiftiFile {
    int version = 1;
    bool bigEndian = false;
    std::array<int, 8> dim{3, 2, 1, 2, 1, 1, 1, 1};
    int datatype = 2;
    std::array<double, 8> pixdim{1, 1, 1, 1, 0, 0, 0, 0};
    double offset = 0;  ///< 0: where it should be
    double slope = 0;
    double intercept = 0;
    int qform = 0;
    int sform = 0;
    std::array<double, 3> quaternion{};
    std::array<double, 12> rows{};
    std::string magic = "n+";
    std::string values{"\0\1\2\3", 4};

    [[nodiscard]] std::string text() const {
        const bool two = version == 2;
        std::string out(two ? 540 : 348, '\0');
        put(out, 0, two ? 540 : 348, 4);
        const std::string name = magic + std::to_string(version) + std::string(1, '\0');
        out.replace(two ? 4 : 344, 4, name);
        if (two) out.replace(8, 4, "\r\n\x1a\n");
        put(out, two ? 12 : 70, datatype, 2);
        for (std::size_t i = 0; i < 8; ++i)
            put(out, two ? 16 + 8 * i : 40 + 2 * i, dim[i], two ? 8 : 2);
        for (std::size_t i = 0; i < 8; ++i) real(out, two ? 104 : 76, i, pixdim[i]);
        const double start = offset != 0 ? offset : two ? 544 : 352;
        if (two)
            put(out, 168, static_cast<std::int64_t>(start), 8);
        else
            real(out, 108, 0, start);
        real(out, two ? 176 : 112, 0, slope);
        real(out, two ? 176 : 112, 1, intercept);
        put(out, two ? 344 : 252, qform, two ? 4 : 2);
        put(out, two ? 348 : 254, sform, two ? 4 : 2);
        for (std::size_t i = 0; i < 3; ++i) real(out, two ? 352 : 256, i, quaternion[i]);
        for (std::size_t i = 0; i < 12; ++i) real(out, two ? 400 : 280, i, rows[i]);
        return out + std::string(4, '\0') + values;
    }

private:
    void put(std::string& out, std::size_t at, std::int64_t value, std::size_t width) const {
        for (std::size_t i = 0; i < width; ++i)
            out[at + (bigEndian ? width - 1 - i : i)] =
                static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xff);
    }
    void real(std::string& out, std::size_t at, std::size_t i, double value) const {
        if (version == 2)
            put(out, at + 8 * i, std::bit_cast<std::int64_t>(value), 8);
        else
            put(out, at + 4 * i, std::bit_cast<std::int32_t>(static_cast<float>(value)), 4);
    }
};

Scene sceneOf(const NiftiFile& file) {
    const auto bytes = VoxBuilder::toBytes(file.text());
    CHECK(isNifti(bytes));
    auto scene = readNifti(bytes, {});
    REQUIRE_MESSAGE(scene, (scene ? "" : scene.error().message));
    return *std::move(scene);
}

Error errorOf(const NiftiFile& file, const Limits& limits = {}) {
    const auto scene = readNifti(VoxBuilder::toBytes(file.text()), {.limits = limits});
    REQUIRE_FALSE(scene);
    CHECK(scene.error().field.starts_with("/grid"));
    return scene.error();
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("read nifti: both versions, both byte orders") {
    for (const int version : {1, 2})
        for (const bool big : {false, true}) {
            CAPTURE(version);
            CAPTURE(big);
            const Scene scene = sceneOf({.version = version, .bigEndian = big});
            CHECK(scene.models[0].size() == Vec3i(2, 1, 2));
            CHECK(scene.materials[scene.models[0].at(Vec3i(1, 0, 0))].source == 1);
            CHECK(scene.materials[scene.models[0].at(Vec3i(0, 0, 1))].source == 2);
            CHECK(scene.format == GridFormat::nifti);
            CHECK(scene.formatDetail == "nifti " + std::to_string(version));
        }
}

TEST_CASE("read nifti: every type") {
    struct Case {
        int code;
        std::string one;  ///< little-endian
    };
    for (const Case& of :
         {Case{2, "\1"}, Case{256, "\1"}, Case{4, {"\1\0", 2}}, Case{512, {"\1\0", 2}},
          Case{8, {"\1\0\0\0", 4}}, Case{768, {"\1\0\0\0", 4}}, Case{16, {"\0\0\x80\x3f", 4}},
          Case{1024, {"\1\0\0\0\0\0\0\0", 8}}, Case{1280, {"\1\0\0\0\0\0\0\0", 8}},
          Case{64, {"\0\0\0\0\0\0\xf0\x3f", 8}}}) {
        CAPTURE(of.code);
        const Scene scene = sceneOf({.dim = {3, 2, 1, 1, 1, 1, 1, 1},
                                     .datatype = of.code,
                                     .values = std::string(of.one.size(), '\0') + of.one});
        CHECK(scene.models[0].countVoxels() == 1);
        CHECK(scene.materials[scene.models[0].at(Vec3i(1, 0, 0))].source == 1);
    }
}

TEST_CASE("read nifti: axes by sform, else by qform, else by the sides of a voxel") {
    const std::array<double, 8> sides{-1, 1, 2, 4, 0, 0, 0, 0};
    CHECK(sceneOf({.pixdim = sides}).spacing == Vec3d(1, 2, 4));
    CHECK(sceneOf({.pixdim = sides}).instances[0].rotation == Mat3i::Identity());

    // Half a turn about z, and the third axis mirrored by pixdim[0].
    const Scene turned = sceneOf({.pixdim = sides, .qform = 1, .quaternion = {0, 0, 1}});
    CHECK(turned.instances[0].rotation == Mat3i(Vec3i(-1, -1, -1).asDiagonal()));
    CHECK(turned.spacing == Vec3d(1, 2, 4));
    // A quarter turn about x: y goes up, z goes back.
    const double half = std::sqrt(0.5);
    const Scene quarter = sceneOf({.pixdim = {1, 1, 2, 4}, .qform = 1, .quaternion = {half, 0, 0}});
    Mat3i expected;
    expected << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    CHECK(quarter.instances[0].rotation == expected);
    CHECK(quarter.spacing == Vec3d(1, 4, 2));

    // Rows of the sform: x' = -3 i, y' = 2 k, z' = 5 j; the qform does not count.
    const Scene rows = sceneOf(
        {.pixdim = sides, .qform = 1, .sform = 2, .rows = {-3, 0, 0, 9, 0, 0, 2, 9, 0, 5, 0, 9}});
    expected << -1, 0, 0, 0, 0, 1, 0, 1, 0;
    CHECK(rows.instances[0].rotation == expected);
    CHECK(rows.spacing == Vec3d(1.5, 1, 2.5));
}

TEST_CASE("read nifti: axes of length one, an extension, bytes that follow, and no scaling") {
    CHECK(sceneOf({.dim = {5, 2, 1, 2, 1, 1, 1, 1}}).models[0].countVoxels() == 3);
    CHECK(sceneOf({.dim = {2, 2, 2, 9, 9, 1, 1, 1}}).models[0].size() == Vec3i(2, 2, 1));
    CHECK(sceneOf({.slope = 1}).models[0].countVoxels() == 3);
    CHECK(sceneOf({.values = std::string("\1\2\3\4padding")}).models[0].countVoxels() == 4);
    NiftiFile extended{.offset = 368};
    extended.values = std::string(16, 'e') + extended.values;
    CHECK(sceneOf(extended).models[0].countVoxels() == 3);
}

TEST_CASE("reject: NIfTI files that hold no label volume") {
    CHECK(errorOf({.dim = {4, 2, 1, 2, 7}}).code == ErrorCode::unsupportedFormat);
    CHECK(errorOf({.dim = {0, 2, 1, 2}}).code == ErrorCode::malformedInput);
    CHECK(errorOf({.dim = {8, 2, 1, 2}}).code == ErrorCode::malformedInput);
    CHECK(errorOf({.dim = {3, 2, 0, 2}}).code == ErrorCode::malformedInput);
    CHECK(errorOf({.dim = {3, -2, 1, 2}}).code == ErrorCode::malformedInput);
    CHECK(errorOf({.datatype = 128}).field == "/grid/header/datatype");
    CHECK(errorOf({.slope = 2}).field == "/grid/header/scl_slope");
    CHECK(errorOf({.slope = 1, .intercept = 1}).field == "/grid/header/scl_slope");
    CHECK(errorOf({.offset = 1e9}).field == "/grid/header/vox_offset");
    CHECK(errorOf({.offset = std::nan("")}).field == "/grid/header/vox_offset");
    CHECK(errorOf({.pixdim = {1, 0, 1, 1}}).field == "/grid/header/pixdim");
    CHECK(errorOf({.pixdim = {1, std::nan(""), 1, 1}}).field == "/grid/header/pixdim");
    CHECK(errorOf({.sform = 1}).field == "/grid/header/pixdim");
    CHECK(errorOf({.values = "abc"}).code == ErrorCode::malformedInput);
    CHECK(errorOf({.magic = "ni"}).message.find(".img") != std::string::npos);
    CHECK(errorOf({.dim = {3, 2000, 2000, 2000}}).code == ErrorCode::tooLarge);
    const std::string whole = NiftiFile{}.text();
    for (std::size_t size = 0; size < whole.size(); size += 5)
        CHECK_FALSE(readNifti(VoxBuilder::toBytes(whole.substr(0, size)), {}));
}
