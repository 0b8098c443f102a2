#include "core/grid/scene.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/formats/read_scene.h"
#include "tests/support/npy_builder.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::VoxBuilder;

namespace {

using Cells = std::map<std::tuple<int, int, int>, std::uint32_t>;  // scene cell -> source

Cells cellsOf(const VoxelGrid& grid) {
    Cells cells;
    grid.voxels.forEach([&](const Vec3i& voxel, MaterialId material) {
        const Vec3i at = voxel + grid.origin;
        cells[{at.x(), at.y(), at.z()}] = grid.materials[material].source;
    });
    return cells;
}

std::vector<Mat3i> allRotations() {
    std::vector<Mat3i> rotations;
    std::array<int, 3> columns{0, 1, 2};
    do {
        for (int signs = 0; signs < 8; ++signs) {
            Mat3i rotation = Mat3i::Zero();
            for (int row = 0; row < 3; ++row)
                rotation(row, columns[static_cast<std::size_t>(row)]) = signs >> row & 1 ? -1 : 1;
            rotations.push_back(rotation);
        }
    } while (std::next_permutation(columns.begin(), columns.end()));
    return rotations;
}

/// One model of this size with random voxels of sources 1..3.
Scene randomScene(const Vec3i& size, unsigned seed) {
    Scene scene;
    for (std::uint32_t source = 1; source <= 3; ++source)
        scene.materials.push_back({.source = source});
    scene.models.emplace_back(size);
    std::mt19937 random(seed);
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x)
                scene.models[0].set(Vec3i(x, y, z),
                                    MaterialId{static_cast<std::uint16_t>(random() % 4)});
    scene.models[0].set(Vec3i(0, 0, 0), MaterialId{1});
    scene.instances.push_back({.frames = {0}});
    scene.format = GridFormat::vox;
    return scene;
}

/// The rule with real numbers: the centre of the cube, turned about the pivot, moved.
Cells slowPlacement(const Scene& scene) {
    const Instance& instance = scene.instances[0];
    const BrickGrid& model = scene.models[0];
    const Vec3d pivot = (model.size() / 2).cast<double>();
    Cells cells;
    model.forEach([&](const Vec3i& voxel, MaterialId material) {
        const Vec3d centre = voxel.cast<double>() + Vec3d::Constant(0.5);
        const Vec3d turned = instance.rotation.cast<double>() * (centre - pivot);
        const Vec3i at = turned.array().floor().matrix().cast<int>() + instance.translation;
        cells[{at.x(), at.y(), at.z()}] = scene.materials[material].source;
    });
    return cells;
}

Result<VoxelGrid> merge(const VoxBuilder& builder, const InputOptions& options = {}) {
    const auto scene = readScene(builder.bytes(), options, {});
    REQUIRE(scene);
    return mergeScene(*scene, options, {});
}

/// Two models that overlap in one cell, colour 1 listed first.
VoxBuilder overlapping(int version) {
    return VoxBuilder(version)
        .size(1, 1, 1)
        .voxels({{0, 0, 0, 1}})
        .size(2, 1, 1)
        .voxels({{0, 0, 0, 2}, {1, 0, 0, 2}})
        .transform(0, 1)
        .group(1, {2, 4})
        .transform(2, 3, {{"_t", "0 0 0"}})
        .shape(3, {0})
        .transform(4, 5, {{"_t", "1 0 0"}})
        .shape(5, {1});
}

}  // namespace

TEST_SUITE_BEGIN("core/grid");

TEST_CASE("differential: all 48 signed permutations, odd and even sizes") {
    unsigned seed = 0;
    for (const Vec3i& size :
         {Vec3i(3, 4, 5), Vec3i(4, 4, 4), Vec3i(5, 3, 1), Vec3i(1, 2, 6), Vec3i(17, 1, 2)})
        for (const Mat3i& rotation : allRotations()) {
            Scene scene = randomScene(size, ++seed);
            scene.instances[0].rotation = rotation;
            scene.instances[0].translation = Vec3i(-7, 11, 2);
            const auto grid = mergeScene(scene, {}, {});
            CAPTURE(seed);
            REQUIRE(grid);
            CHECK(cellsOf(*grid) == slowPlacement(scene));
        }
}

TEST_CASE("merge scene: an instance that is not centred keeps its low corner, for all rotations") {
    for (const Mat3i& rotation : allRotations()) {
        Scene scene = randomScene(Vec3i(3, 4, 5), 1);
        for (int corner = 0; corner < 8; ++corner)
            scene.models[0].set(Vec3i(corner & 1 ? 2 : 0, corner & 2 ? 3 : 0, corner & 4 ? 4 : 0),
                                MaterialId{1});
        scene.instances[0].rotation = rotation;
        scene.instances[0].centered = false;
        scene.instances[0].translation = Vec3i(100, -20, 3);
        const auto grid = mergeScene(scene, {}, {});
        REQUIRE(grid);
        CHECK(grid->origin == Vec3i(100, -20, 3));
        CHECK(grid->voxels.size() == (rotation.cwiseAbs() * Vec3i(3, 4, 5)).eval());
    }
}

TEST_CASE("merge scene: the grid is the bounding box of the voxels") {
    const auto grid =
        merge(VoxBuilder().size(100, 50, 20).voxels({{90, 40, 7, 1}, {91, 44, 7, 1}}));
    REQUIRE(grid);
    CHECK(grid->voxels.size() == Vec3i(2, 5, 1));
    CHECK(grid->origin == Vec3i(90, 40, 7));
}

TEST_CASE("merge scene: version 200 shows the earlier of two instances, 150 the later") {
    const auto earlier = merge(overlapping(200));
    const auto later = merge(overlapping(150));
    REQUIRE(earlier);
    REQUIRE(later);
    CHECK(cellsOf(*earlier) == Cells{{{0, 0, 0}, 1}, {{1, 0, 0}, 2}});
    CHECK(cellsOf(*later) == Cells{{{0, 0, 0}, 2}, {{1, 0, 0}, 2}});
    CHECK(later->materials.size() == 2);  // colour 1 is covered, so it is dropped
}

TEST_CASE("merge scene: hidden parts are skipped unless they are asked for") {
    const VoxBuilder file = VoxBuilder()
                                .cube(1, 1)
                                .cube(1, 2)
                                .group(0, {1, 2})
                                .shape(1, {0})
                                .transform(2, 3, {{"_t", "5 0 0"}}, {{"_hidden", "1"}})
                                .shape(3, {1});
    CHECK(merge(file)->voxels.countVoxels() == 1);
    CHECK(merge(file, {.keepHidden = true})->voxels.countVoxels() == 2);
    const auto nothing =
        merge(VoxBuilder().cube(1, 1).transform(0, 1, {}, {{"_hidden", "1"}}).shape(1, {0}));
    REQUIRE_FALSE(nothing);
    CHECK(nothing.error().code == ErrorCode::emptyGrid);
    CHECK(nothing.error().message.find("hidden") != std::string::npos);
}

TEST_CASE("merge scene: a frame is one model of the pack, the last one for frames after it") {
    const VoxBuilder file =
        VoxBuilder(150).chunk("PACK", VoxBuilder::number(3)).cube(1, 5).cube(1, 6).cube(1, 7);
    for (const auto& [frame, source] : std::map<int, std::uint32_t>{{0, 5}, {1, 6}, {2, 7}, {9, 7}})
        CHECK(cellsOf(*merge(file, {.frame = frame})) == Cells{{{0, 0, 0}, source}});
}

TEST_CASE("merge scene: keys with times hold until the next one") {
    Scene scene = randomScene(Vec3i(1, 1, 1), 1);
    scene.models.emplace_back(Vec3i(1, 1, 1));
    scene.models[1].set(Vec3i(0, 0, 0), MaterialId{3});
    scene.instances[0].frames = {0, 1};
    scene.instances[0].frameTimes = {2, 10};
    for (const int frame : {0, 2, 9})
        CHECK(cellsOf(*mergeScene(scene, {.frame = frame}, {})).begin()->second == 1);
    CHECK(cellsOf(*mergeScene(scene, {.frame = 10}, {})).begin()->second == 3);
}

TEST_CASE("merge scene: unused materials are dropped, labels are set") {
    const auto grid = merge(VoxBuilder()
                                .size(3, 1, 1)
                                .voxels({{0, 0, 0, 9}, {1, 0, 0, 200}, {2, 0, 0, 9}})
                                .material(200, {{"_type", "_glass"}}));
    REQUIRE(grid);
    REQUIRE(grid->materials.size() == 3);
    CHECK(grid->materials[MaterialId{1}].source == 9);
    CHECK(grid->labelAt(Vec3i(0, 0, 0)) == Label{1});
    CHECK(grid->labelAt(Vec3i(1, 0, 0)) == Label{2});
    CHECK(grid->labelAt(Vec3i(-1, 0, 0)) == Label{0});
    CHECK(grid->labels.raw() == std::vector<std::string>{"", "opaque", "glass"});
}

TEST_CASE("merge scene: voxels without a label disappear and the grid shrinks") {
    const InputOptions options{.labels = LabelMode::map, .labelMap = {{"kept", {2}}}};
    const VoxBuilder file =
        VoxBuilder().size(9, 3, 3).voxels({{0, 0, 0, 1}, {5, 1, 1, 2}, {6, 1, 2, 2}, {8, 2, 2, 3}});
    const auto grid = merge(file, options);
    REQUIRE(grid);
    CHECK(grid->voxels.size() == Vec3i(2, 1, 2));
    CHECK(grid->origin == Vec3i(5, 1, 1));
    CHECK(grid->materials.size() == 2);
    CHECK(cellsOf(*grid) == Cells{{{5, 1, 1}, 2}, {{6, 1, 2}, 2}});

    const auto nothing = merge(file, {.labels = LabelMode::map, .labelMap = {{"none", {77}}}});
    REQUIRE_FALSE(nothing);
    CHECK(nothing.error().code == ErrorCode::emptyGrid);
    CHECK(nothing.error().field == "/options/labels");
}

TEST_CASE("merge scene: a volume of values has one label a value") {
    const rivage::test::NpyFile file{
        .descr = "<u2", .shape = "(1, 2, 2)", .values = {300, 0, 7, 7}};
    const auto scene = readScene(file.bytes(), {}, {});
    REQUIRE(scene);
    const auto grid = mergeScene(*scene, {}, {});
    REQUIRE(grid);
    CHECK(grid->labels.raw() == std::vector<std::string>{"", "7", "300"});
    CHECK(grid->origin == Vec3i(0, 0, 0));
    CHECK(cellsOf(*grid) == Cells{{{0, 0, 0}, 300}, {{0, 1, 0}, 7}, {{1, 1, 0}, 7}});
}

TEST_CASE("reject: limits of extent, voxels, materials and memory, and the limits themselves") {
    Scene scene = randomScene(Vec3i(1, 1, 1), 1);
    scene.instances.push_back({.frames = {0}, .translation = Vec3i(0, 9, 0)});
    const auto code = [&](const Limits& limits) {
        const auto grid = mergeScene(scene, {}, {.limits = limits});
        return grid ? ErrorCode::internal : grid.error().code;
    };
    CHECK(code({.maxExtent = 10}) == ErrorCode::internal);
    CHECK(code({.maxExtent = 9}) == ErrorCode::tooLarge);
    CHECK(code({.maxVoxels = 2 * BrickGrid::kBrickVoxels}) == ErrorCode::internal);
    CHECK(code({.maxVoxels = 1}) == ErrorCode::tooLarge);
    CHECK(code({.maxMaterials = 1}) == ErrorCode::internal);
    CHECK(code({.maxMaterials = 0}) == ErrorCode::tooManyLabels);
    CHECK(code({.maxMemory = 1000}) == ErrorCode::memoryBudget);
}

TEST_CASE("open border: a volume stays whole, a scene is the box of its voxels") {
    for (const GridFormat format : {GridFormat::npy, GridFormat::vox}) {
        Scene scene = randomScene(Vec3i(9, 7, 5), 2);
        scene.format = format;
        scene.models[0] = BrickGrid(Vec3i(9, 7, 5));
        scene.models[0].set(Vec3i(2, 3, 4), MaterialId{1});
        scene.models[0].set(Vec3i(5, 3, 2), MaterialId{2});
        const auto closed = mergeScene(scene, {}, {});
        const auto open = mergeScene(scene, {.border = Border::open}, {});
        REQUIRE(closed);
        REQUIRE(open);
        CHECK_FALSE(closed->openBorder);
        CHECK(closed->voxels.size() == Vec3i(4, 1, 3));
        CHECK(open->openBorder);
        const bool volume = format == GridFormat::npy;
        CHECK(open->voxels.size() == (volume ? Vec3i(9, 7, 5) : Vec3i(4, 1, 3)));
        CHECK(cellsOf(*open) == cellsOf(*closed));
        // Voxels that a label map drops do not move the border.
        const InputOptions map{.labels = LabelMode::map,
                               .labelMap = {{.name = "one", .values = {1}}},
                               .border = Border::open};
        CHECK(mergeScene(scene, map, {})->voxels.size() == open->voxels.size());
    }
}

TEST_CASE("spacing: is told in the shortest side") {
    const Scene scene = randomScene(Vec3i(2, 2, 2), 1);
    CHECK(mergeScene(scene, {.spacing = Vec3d(0.5, 1, 0.25)}, {})->spacing == Vec3d(2, 4, 1));
    CHECK(mergeScene(scene, {}, {})->spacing == Vec3d(1, 1, 1));
    Scene tall = scene;
    tall.spacing = Vec3d(3, 3, 6);
    CHECK(mergeScene(tall, {}, {})->spacing == Vec3d(1, 1, 2));
    CHECK(mergeScene(tall, {.spacing = Vec3d::Ones()}, {})->spacing == Vec3d(1, 1, 1));
}

TEST_CASE("reject: a scene that spans the whole range of translations") {
    Scene scene = randomScene(Vec3i(1, 1, 1), 1);
    scene.instances[0].translation = Vec3i::Constant(1 << 30);
    scene.instances.push_back({.frames = {0}, .translation = Vec3i::Constant(-(1 << 30))});
    const auto grid = mergeScene(scene, {}, {});
    REQUIRE_FALSE(grid);
    CHECK(grid.error().code == ErrorCode::tooLarge);
    CHECK(grid.error().actual == (1ULL << 31) + 1);
}

TEST_CASE("reject: more placed cells than a merge may visit") {
    Scene scene = randomScene(Vec3i(1, 1, 1), 1);
    const Limits limits{.maxVoxels = BrickGrid::kBrickVoxels};
    scene.instances.resize(16, scene.instances[0]);
    CHECK(mergeScene(scene, {}, {.limits = limits}));
    scene.instances.resize(18, scene.instances[0]);
    const auto grid = mergeScene(scene, {}, {.limits = {.maxVoxels = BrickGrid::kBrickVoxels - 1}});
    REQUIRE_FALSE(grid);
    CHECK(grid.error().code == ErrorCode::tooLarge);
}

TEST_CASE("reject: an empty scene, and one whose models are empty") {
    CHECK(mergeScene(Scene{}, {}, {}).error().code == ErrorCode::emptyGrid);
    CHECK(merge(VoxBuilder().size(4, 4, 4).voxels({})).error().code == ErrorCode::emptyGrid);
}

TEST_CASE("merge scene: gives up when asked to") {
    RunContext run;
    run.stopRequested = [] { return true; };
    const auto grid = mergeScene(randomScene(Vec3i(2, 2, 2), 1), {}, run);
    REQUIRE_FALSE(grid);
    CHECK(grid.error().code == ErrorCode::cancelled);
}

TEST_SUITE_END();
