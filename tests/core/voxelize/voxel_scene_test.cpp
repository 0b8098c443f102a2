#include <doctest/doctest.h>

#include <set>

#include "core/formats/read_scene.h"
#include "core/formats/write_vox.h"
#include "core/grid/oklab.h"
#include "core/grid/scene.h"
#include "core/voxelize/reduce_palette.h"
#include "core/voxelize/voxel_scene.h"
#include "tests/support/grids.h"

using namespace rivage::test;

namespace {

/// Materials of random colours, one label.
IdVector<MaterialId, Material> randomMaterials(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    IdVector<MaterialId, Material> materials(count + 1);
    for (std::size_t i = 1; i <= count; ++i) {
        Material& material = materials.raw()[i];
        material.label = Label{1};
        material.source = static_cast<std::uint32_t>(i);
        for (int c = 0; c < 3; ++c) material.color[c] = static_cast<std::uint8_t>(random());
    }
    return materials;
}

/// A long sparse grid: `count` voxels anywhere in it.
VoxelGrid scattered(const Vec3i& size, int count, std::uint32_t seed) {
    std::mt19937 random(seed);
    VoxelGrid grid;
    grid.voxels = BrickGrid(size);
    grid.materials = randomMaterials(7, seed);
    grid.labels.resize(2);
    for (int i = 0; i < count; ++i) {
        Vec3i at;
        for (int axis = 0; axis < 3; ++axis) at[axis] = static_cast<int>(random() % size[axis]);
        grid.voxels.set(at, static_cast<MaterialId>(1 + random() % 7));
    }
    // Its corners, so that reading it again gives the same box.
    grid.voxels.set(Vec3i::Zero(), MaterialId{1});
    grid.voxels.set(size - Vec3i::Ones(), MaterialId{2});
    return grid;
}

VoxelGrid readBack(const Scene& scene) {
    const auto bytes = writeVox(scene);
    REQUIRE(bytes);
    const auto again = readScene(*bytes, {}, {});
    REQUIRE(again);
    auto grid = mergeScene(*again, {}, {});
    REQUIRE(grid);
    return *std::move(grid);
}

}  // namespace

TEST_SUITE("core/voxelize") {
    TEST_CASE("tiles: a long grid comes back voxel by voxel, at its place") {
        for (const Vec3i& size :
             {Vec3i(600, 300, 20), Vec3i(257, 5, 256), Vec3i(3, 256, 513), Vec3i(256, 255, 1)}) {
            CAPTURE(size.x());
            VoxelGrid grid = scattered(size, 400, 9);
            grid.origin = Vec3i(-301, 17, -4);
            const VoxelGrid input = grid;
            const auto made = voxelScene(std::move(grid), {});
            REQUIRE(made);
            for (const BrickGrid& model : made->scene.models) CHECK(model.size().maxCoeff() <= 256);
            const VoxelGrid back = readBack(made->scene);
            CHECK(back.origin == input.origin);
            REQUIRE(back.voxels.size() == size);
            CHECK(back.voxels.countVoxels() == input.voxels.countVoxels());
            input.voxels.forEach([&](const Vec3i& at, MaterialId m) {
                CHECK(back.materials[back.voxels.at(at)].color == input.materials[m].color);
            });
        }
    }

    TEST_CASE("tiles: empty ones are left out") {
        VoxelGrid grid;
        grid.voxels = BrickGrid({1000, 1000, 300});
        grid.materials = randomMaterials(1, 1);
        grid.labels.resize(2);
        grid.voxels.set({0, 0, 0}, MaterialId{1});
        grid.voxels.set({999, 999, 299}, MaterialId{1});
        const auto made = voxelScene(std::move(grid), {});
        REQUIRE(made);
        CHECK(made->scene.models.size() == 2);
        CHECK(made->scene.warnings.empty());
    }

    TEST_CASE("tiles: what would leave the world of the editor goes to its middle") {
        VoxelGrid grid = scattered({300, 4, 4}, 10, 3);
        grid.origin = Vec3i(900, -1000, 20);
        const auto made = voxelScene(std::move(grid), {});
        REQUIRE(made);
        CHECK(readBack(made->scene).origin == Vec3i(-150, -1000, 20));
        CHECK(made->scene.warnings.size() == 1);
    }

    TEST_CASE("palette: few materials keep the entry that they had, else their order") {
        auto materials = randomMaterials(3, 1);
        materials[MaterialId{1}].source = 200;
        materials[MaterialId{2}].source = 7;
        materials[MaterialId{3}].source = 255;
        materials[MaterialId{2}].roughness = 0.25;
        const auto kept = reducePalette(materials, {0, 5, 6, 0}, 255, {});
        REQUIRE(kept);
        CHECK_FALSE(kept->reduced);
        CHECK(kept->colors == 2);
        CHECK(kept->newId[1] == MaterialId{200});
        CHECK(kept->newId[2] == MaterialId{7});
        CHECK(kept->materials[MaterialId{7}].roughness == 0.25);
        materials[MaterialId{3}].source = 300;
        const auto moved = reducePalette(materials, {0, 5, 6, 7}, 255, {});
        REQUIRE(moved);
        CHECK(moved->newId[1] == MaterialId{1});
        CHECK(moved->newId[3] == MaterialId{3});
    }

    TEST_CASE("palette: 3000 random colours become 255, and the error is what it says") {
        const auto materials = randomMaterials(3000, 4);
        std::vector<std::uint64_t> voxels(3001);
        for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = i % 5;
        voxels[77] = 100000;  // one that fills nearly everything stays nearly as it is
        const auto made = reducePalette(materials, voxels, 255, {});
        REQUIRE(made);
        CHECK(made->reduced);
        CHECK(made->colors <= 255);
        CHECK(made->colors >= 250);
        double max = 0;
        double sum = 0;
        double total = 0;
        for (std::size_t i = 1; i <= 3000; ++i) {
            const Rgba8 color = made->materials[made->newId[i]].color;
            const double error = (oklabOf(color) - oklabOf(materials.raw()[i].color)).norm();
            if (voxels[i] > 0) max = std::max(max, error);
            sum += error * static_cast<double>(voxels[i]);
            total += static_cast<double>(voxels[i]);
        }
        CHECK(made->errorMax == doctest::Approx(max));
        CHECK(made->errorMean == doctest::Approx(sum / total));
        CHECK(max < 0.15);
        CHECK(sum / total < 0.01);
    }

    TEST_CASE("palette: only colours are joined, not metal with glass") {
        auto materials = randomMaterials(600, 8);
        for (std::size_t i = 1; i <= 600; ++i) {
            materials.raw()[i].kind = i % 3 == 0 ? MaterialClass::metal : MaterialClass::opaque;
            materials.raw()[i].metallic = i % 3 == 0 ? 0.5 : 0;
        }
        const auto made = reducePalette(materials, std::vector<std::uint64_t>(601, 1), 255, {});
        REQUIRE(made);
        for (std::size_t i = 1; i <= 600; ++i) {
            const Material& material = made->materials[made->newId[i]];
            CHECK(material.kind == materials.raw()[i].kind);
            CHECK(material.metallic == materials.raw()[i].metallic);
        }
        for (std::size_t i = 1; i <= 600; ++i)
            materials.raw()[i].roughness = static_cast<double>(i) / 600;
        const auto refused = reducePalette(materials, std::vector<std::uint64_t>(601, 1), 255, {});
        REQUIRE_FALSE(refused);
        CHECK(refused.error().code == ErrorCode::tooManyLabels);
    }

    TEST_CASE("palette: equal colours cost nothing") {
        auto materials = randomMaterials(400, 2);
        for (std::size_t i = 1; i <= 400; ++i)
            materials.raw()[i].color = materials.raw()[1 + i % 100].color;
        const auto made = reducePalette(materials, std::vector<std::uint64_t>(401, 1), 255, {});
        REQUIRE(made);
        CHECK(made->colors <= 100);
        CHECK(made->errorMax < 0.005);  // the colours of the entries are rounded to 8 bits
    }

    TEST_CASE("oklab: white, black and grey; every level comes back") {
        CHECK(oklabOf({255, 255, 255, 255})[0] == doctest::Approx(1).epsilon(1e-6));
        CHECK(oklabOf({0, 0, 0, 255}).norm() == 0);
        for (int i = 0; i < 256; ++i) {
            const auto level = static_cast<std::uint8_t>(i);
            const Rgba8 color{level, static_cast<std::uint8_t>(255 - i), 77, 255};
            CHECK(srgbOfOklab(oklabOf(color)) == color);
        }
    }
}
