#include "core/formats/vox_materials.h"

#include <doctest/doctest.h>

#include <set>
#include <string>

#include "core/formats/read_vox.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::VoxBuilder;

namespace {

/// Material 9 of a file with these properties.
Material materialOf(const VoxBuilder::Dict& properties) {
    const auto scene = readVox(VoxBuilder().cube(1, 9).material(9, properties).bytes(), {}, {});
    REQUIRE(scene);
    return scene->materials[MaterialId{9}];
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("default palette: some entries of the published table, and no colour twice") {
    const auto palette = defaultVoxPalette();
    CHECK(palette[0] == Rgba8{0xff, 0xff, 0xff, 0xff});
    CHECK(palette[1] == Rgba8{0xff, 0xff, 0xcc, 0xff});
    CHECK(palette[6] == Rgba8{0xff, 0xcc, 0xff, 0xff});
    CHECK(palette[36] == Rgba8{0xcc, 0xff, 0xff, 0xff});
    CHECK(palette[214] == Rgba8{0x00, 0x00, 0x33, 0xff});
    CHECK(palette[215] == Rgba8{0xee, 0x00, 0x00, 0xff});
    CHECK(palette[224] == Rgba8{0x11, 0x00, 0x00, 0xff});
    CHECK(palette[225] == Rgba8{0x00, 0xee, 0x00, 0xff});
    CHECK(palette[235] == Rgba8{0x00, 0x00, 0xee, 0xff});
    CHECK(palette[254] == Rgba8{0x11, 0x11, 0x11, 0xff});
    CHECK(palette[255] == Rgba8{0, 0, 0, 0});
    CHECK(std::set<Rgba8>(palette.begin(), palette.end()).size() == 256);
}

TEST_CASE("vox materials: no chunk, no type and the diffuse type are plain") {
    for (const Material& plain :
         {materialOf({}), materialOf({{"_rough", "0.1"}}),
          materialOf({{"_type", "_diffuse"}, {"_rough", "0.1"}, {"_metal", "1"}})}) {
        CHECK(plain.kind == MaterialClass::opaque);
        CHECK(plain.roughness == 1);
        CHECK(plain.metallic == 0);
        CHECK(plain.ior == 1.5);
        CHECK(plain.emission == 0);
    }
}

TEST_CASE("vox materials: metal") {
    const Material metal =
        materialOf({{"_type", "_metal"}, {"_metal", "0.75"}, {"_rough", "0.25"}});
    CHECK(metal.kind == MaterialClass::metal);
    CHECK(metal.metallic == 0.75);
    CHECK(metal.roughness == 0.25);
    CHECK(materialOf({{"_type", "_metal"}, {"_weight", "0.5"}}).metallic == 0.5);
}

TEST_CASE("vox materials: glass takes its index from _ri, else from 1 + _ior") {
    const Material glass =
        materialOf({{"_type", "_glass"}, {"_trans", "0.9"}, {"_ri", "1.45"}, {"_ior", "0.3"}});
    CHECK(glass.kind == MaterialClass::glass);
    CHECK(glass.transmission == 0.9);
    CHECK(glass.ior == 1.45);
    const Material old = materialOf({{"_type", "_glass"}, {"_alpha", "0.4"}, {"_ior", "0.25"}});
    CHECK(old.transmission == 0.4);
    CHECK(old.ior == 1.25);
}

TEST_CASE("vox materials: light grows exponentially with its power") {
    const Material dim = materialOf({{"_type", "_emit"}, {"_emit", "0.5"}, {"_flux", "0"}});
    CHECK(dim.kind == MaterialClass::emissive);
    CHECK(dim.emission == 0.5);
    CHECK(dim.emissiveStrength == 2);
    CHECK(materialOf({{"_type", "_emit"}, {"_flux", "3"}}).emissiveStrength == 16);
}

TEST_CASE("vox materials: clouds and blends") {
    CHECK(materialOf({{"_type", "_media"}}).kind == MaterialClass::cloud);
    CHECK(materialOf({{"_type", "_cloud"}}).kind == MaterialClass::cloud);
    CHECK(materialOf({{"_type", "_blend"}, {"_trans", "0.8"}}).kind == MaterialClass::glass);
    CHECK(materialOf({{"_type", "_blend"}, {"_metal", "0.8"}}).kind == MaterialClass::metal);
    CHECK(materialOf({{"_type", "_blend"}}).kind == MaterialClass::opaque);
    CHECK(materialOf({{"_type", "_strange"}}).kind == MaterialClass::opaque);
}

TEST_CASE("vox materials: values out of range are clamped, and what is no number is absent") {
    const Material wild = materialOf({{"_type", "_glass"},
                                      {"_trans", "1e300"},
                                      {"_rough", "-3"},
                                      {"_ri", "nan"},
                                      {"_ior", "-0.5"}});
    CHECK(wild.transmission == 1);
    CHECK(wild.roughness == 0);
    CHECK(wild.ior == 1);
    CHECK(materialOf({{"_type", "_emit"}, {"_flux", "inf"}, {"_emit", "x"}}).emissiveStrength == 2);
}

TEST_CASE("vox materials: the binary form of version 150") {
    const std::string half = VoxBuilder::number(0x3f000000);
    const std::string nan = VoxBuilder::number(0x7fc00000);
    const auto legacy = [](std::uint32_t id, std::uint32_t type, const std::string& weight,
                           std::uint32_t bits, const std::string& values) {
        return VoxBuilder::number(id) + VoxBuilder::number(type) + weight +
               VoxBuilder::number(bits) + values;
    };
    const auto scene = readVox(VoxBuilder(150)
                                   .cube(1, 1)
                                   .chunk("MATT", legacy(1, 0, half, 2, half))
                                   .chunk("MATT", legacy(2, 1, half, 2 | 128, half))
                                   .chunk("MATT", legacy(3, 2, half, 8, half))
                                   .chunk("MATT", legacy(4, 3, half, 32, half))
                                   .chunk("MATT", legacy(5, 1, nan, 2, nan))
                                   .chunk("MATT", legacy(6, 77, half, 0, ""))
                                   .bytes(),
                               {}, {});
    REQUIRE(scene);
    const auto& materials = scene->materials;
    CHECK(materials[MaterialId{1}].roughness == 1);
    CHECK(materials[MaterialId{2}].kind == MaterialClass::metal);
    CHECK(materials[MaterialId{2}].metallic == 0.5);
    CHECK(materials[MaterialId{2}].roughness == 0.5);
    CHECK(materials[MaterialId{3}].transmission == 0.5);
    CHECK(materials[MaterialId{3}].ior == 1.5);
    CHECK(materials[MaterialId{4}].emissiveStrength == 8);
    CHECK(materials[MaterialId{5}].metallic == 1);
    CHECK(materials[MaterialId{6}].kind == MaterialClass::opaque);
}

TEST_CASE("vox materials: IMAP moves what the artist sees, not the colour of a voxel") {
    std::string order;
    for (int i = 0; i < 256; ++i) order += static_cast<char>((i + 3) & 255);
    std::string notes = VoxBuilder::number(32);
    for (int row = 31; row >= 0; --row) notes += VoxBuilder::string("row " + std::to_string(row));
    const auto scene = readVox(
        VoxBuilder().cube(1, 12).palette().chunk("IMAP", order).chunk("NOTE", notes).bytes(), {},
        {});
    REQUIRE(scene);
    const Material& material = scene->materials[MaterialId{12}];
    CHECK(material.color == Rgba8{11, 244, 7, 255});
    CHECK(material.source == 10);
    CHECK(material.name == "row 1");  // entries 9 to 16
}

TEST_SUITE_END();
