#include "core/samples/samples.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/formats/read_scene.h"
#include "core/pipeline.h"

using namespace rivage::core;

namespace {

VoxelGrid gridOf(std::string_view name, LabelMode labels) {
    const auto bytes = sampleScene(std::string(name));
    REQUIRE(bytes);
    const InputOptions options{.labels = labels};
    const auto scene = readScene(*bytes, options, {});
    REQUIRE(scene);
    auto grid = mergeScene(*scene, options, {});
    REQUIRE(grid);
    return *std::move(grid);
}

/// Surfels by label pair, found by comparing every voxel with its three next ones.
std::map<std::pair<int, int>, std::size_t> surfelsByPair(const VoxelGrid& grid) {
    std::map<std::pair<int, int>, std::size_t> surfels;
    const Vec3i& size = grid.voxels.size();
    for (int z = -1; z < size.z(); ++z)
        for (int y = -1; y < size.y(); ++y)
            for (int x = -1; x < size.x(); ++x)
                for (int axis = 0; axis < 3; ++axis) {
                    const Vec3i voxel(x, y, z);
                    const int a = index(grid.labelAt(voxel));
                    const int b = index(grid.labelAt(voxel + Vec3i::Unit(axis)));
                    if (a != b) ++surfels[{std::min(a, b), std::max(a, b)}];
                }
    return surfels;
}

std::uint64_t checksum(const std::vector<std::byte>& bytes) {
    std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a
    for (const std::byte b : bytes)
        hash = (hash ^ std::to_integer<std::uint64_t>(b)) * 1099511628211ULL;
    return hash;
}

template <typename Solid>
void checkSolid(std::string_view name, const Solid& solid) {
    const VoxelGrid grid = gridOf(name, LabelMode::automatic);
    const Vec3i offset = grid.origin - sampleOrigin(solid.size);  // in the model
    for (int z = 0; z < solid.size.z(); ++z)
        for (int y = 0; y < solid.size.y(); ++y)
            for (int x = 0; x < solid.size.x(); ++x) {
                const bool inside = signedDistance(solid, Vec3d(x + 0.5, y + 0.5, z + 0.5)) < 0;
                CHECK((grid.voxels.at(Vec3i(x, y, z) - offset) != MaterialId{0}) == inside);
            }
    // A margin of one voxel at least, so that the solid is not cut by its model.
    CHECK((offset.array() >= 1).all());
    CHECK(((offset + grid.voxels.size()).array() < solid.size.array()).all());
}

}  // namespace

TEST_SUITE_BEGIN("core/samples");

TEST_CASE("samples: all of them are written, read back and merged with their labels") {
    const std::map<std::string_view, std::size_t> labels{
        {"island", 2}, {"sphere", 1}, {"torus", 1},        {"rotated_box", 1}, {"balls", 3},
        {"foam", 24},  {"house", 2},  {"checkerboard", 1}, {"voxel", 1},       {"barn", 1}};
    REQUIRE(sampleNames().size() == labels.size());
    for (const SampleInfo& info : sampleInfos()) {
        CAPTURE(info.name);
        const VoxelGrid grid = gridOf(info.name, info.labels);
        CHECK(grid.labels.size() - 1 == labels.at(info.name));
        for (const Material& material : grid.materials)
            CHECK((&material == &*grid.materials.begin() || material.label != Label{0}));
    }
}

TEST_CASE("samples: an unknown name is refused, and the answer names those that exist") {
    const auto scene = sampleScene("lake");
    REQUIRE_FALSE(scene);
    CHECK(scene.error().code == ErrorCode::notFound);
    CHECK(scene.error().message.find("island") != std::string::npos);
}

TEST_CASE("samples: the island is 64x68x40 with two labels and three interfaces") {
    const VoxelGrid grid = gridOf("island", LabelMode::automatic);
    CHECK(grid.voxels.size() == Vec3i(64, 68, 40));
    CHECK(grid.origin == Vec3i(-32, -34, 0));
    REQUIRE(grid.labels.size() == 3);
    const auto surfels = surfelsByPair(grid);
    REQUIRE(surfels.size() == 3);
    CHECK(surfels.at({0, 1}) > 8000);  // land and air, with the sides and the floor of the box
    CHECK(surfels.at({0, 2}) > 4000);  // sea and air
    CHECK(surfels.at({1, 2}) > 4000);  // sea and land
    std::map<std::string, int> names;
    for (const Material& material : grid.materials) ++names[material.name];
    for (const char* name : {"sea", "sand", "grass", "rock", "snow", "earth"})
        CHECK(names.count(name) == 1);
}

TEST_CASE("samples: the land of the island is one piece with a floor under all of the sea") {
    const VoxelGrid grid = gridOf("island", LabelMode::automatic);
    for (int y = 0; y < 68; ++y)
        for (int x = 0; x < 64; ++x) {
            int state = 1;  // land, then sea, then air, never back
            for (int z = 0; z < 40; ++z) {
                const int label = index(grid.labelAt(Vec3i(x, y, z)));
                const int next = label == 1 ? 1 : label == 2 ? 2 : 3;
                CHECK(next >= state);
                state = next;
            }
            CHECK(grid.labelAt(Vec3i(x, y, 1)) == Label{1});
            CHECK(grid.labelAt(Vec3i(x, y, 10)) != Label{0});
        }
}

TEST_CASE("samples: the analytic solids are where their parameters say") {
    checkSolid("sphere", SampleSphere{});
    checkSolid("torus", SampleTorus{});
    checkSolid("rotated_box", SampleBox{});
    const Mat3d axes = SampleBox{}.axes();
    CHECK((axes.transpose() * axes - Mat3d::Identity()).cwiseAbs().maxCoeff() < 1e-15);
    CHECK(axes.cwiseAbs().maxCoeff() < 0.9);
}

TEST_CASE("samples: signed distances are distances") {
    CHECK(signedDistance(SampleSphere{}, SampleSphere{}.center) == -12.3);
    const SampleBox box;
    const Vec3d corner = box.center + box.axes() * (box.halfSides + Vec3d(3, 4, 12));
    CHECK(signedDistance(box, corner) == doctest::Approx(13));
    CHECK(signedDistance(box, box.center) == doctest::Approx(-7.4));
    const SampleTorus torus;
    CHECK(signedDistance(torus, torus.center) == doctest::Approx(15.6 - 6.2));
}

TEST_CASE("samples: the three balls touch one another along one line") {
    const auto surfels = surfelsByPair(gridOf("balls", LabelMode::automatic));
    CHECK(surfels.size() == 6);
}

TEST_CASE("samples: no two voxels of the checkerboard share a face") {
    const VoxelGrid grid = gridOf("checkerboard", LabelMode::automatic);
    CHECK(grid.voxels.countVoxels() == 256);
    CHECK(surfelsByPair(grid).at({0, 1}) == 256 * 6);
}

TEST_CASE("samples: a voxel is a voxel") {
    const VoxelGrid grid = gridOf("voxel", LabelMode::automatic);
    CHECK(grid.voxels.size() == Vec3i(1, 1, 1));
    CHECK(surfelsByPair(grid).at({0, 1}) == 6);
}

TEST_CASE("determinism: the bytes of the samples are the stored ones") {
    const std::map<std::string, std::uint64_t> stored{
        {"island", 0xa36d451e7221fa98ULL}, {"sphere", 0xac9fef9133290f05ULL},
        {"torus", 0x76905c79b024ea3dULL},  {"rotated_box", 0xf372aa9ac414277bULL},
        {"balls", 0x8323fc7cbc74e32dULL},  {"foam", 0x10a8ca0b6df10e46ULL},
        {"house", 0x38b2a0f63628cad6ULL},  {"checkerboard", 0x124a5e5bcf908b63ULL},
        {"voxel", 0x0ebd7c0b5bf64f28ULL},  {"barn", 0xbc524a680aadf33cULL}};
    for (const std::string& name : sampleNames()) {
        CAPTURE(name);
        CHECK(stored.count(name) == 1);
        CHECK(stored.at(name) == checksum(*sampleScene(name)));
    }
}

TEST_SUITE_END();
