#include <array>
#include <cstdint>
#include <vector>

#include "core/samples/sample_scenes.h"

/// Scenes of several labels that touch, and two scenes of single voxels.
namespace rivage::core {
namespace {

/// Squared distance of the centre of a voxel to a point given in tenths of a voxel, in (1/20)^2:
/// whole numbers, so that ties fall the same way everywhere.
std::int64_t distance2(const Vec3i& voxel, const Vec3i& tenths) {
    const Vec3i d = 20 * voxel + Vec3i::Constant(10) - 2 * tenths;
    return static_cast<std::int64_t>(d.x()) * d.x() + static_cast<std::int64_t>(d.y()) * d.y() +
           static_cast<std::int64_t>(d.z()) * d.z();
}

/// Index of the nearest of `points`, the first on a tie.
std::size_t nearest(const Vec3i& voxel, const std::vector<Vec3i>& points) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
        if (distance2(voxel, points[i]) < distance2(voxel, points[best])) best = i;
    return best;
}

template <typename Visit>
void forEachCell(const Vec3i& size, Visit&& visit) {
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x) visit(Vec3i(x, y, z));
}

}  // namespace

/// Three balls of radius 9 whose centres are 15 voxels apart; where two overlap, the plane half
/// way between their centres parts them, and the three planes meet in one line.
Scene makeBalls() {
    Scene scene = emptySample(Vec3i(35, 32, 20), "balls");
    const std::array<MaterialId, 3> materials{
        addPaletteRow(scene, {.name = "clay"}, {{206, 92, 74, 255}}),
        addPaletteRow(scene,
                      {.kind = MaterialClass::glass,
                       .roughness = 0.1,
                       .transmission = 0.6,
                       .ior = 1.5,
                       .name = "glass"},
                      {{96, 170, 210, 255}}),
        addPaletteRow(scene,
                      {.kind = MaterialClass::cloud,
                       .roughness = 1,
                       .transmission = 0.2,
                       .ior = 1,
                       .name = "cloud"},
                      {{238, 238, 232, 255}})};
    const std::vector<Vec3i> centers{{100, 100, 100}, {250, 100, 100}, {175, 230, 100}};
    constexpr std::int64_t kRadius = 180;  // twentieths of a voxel
    forEachCell(scene.models.front().size(), [&](const Vec3i& voxel) {
        const std::size_t ball = nearest(voxel, centers);
        if (distance2(voxel, centers[ball]) < kRadius * kRadius)
            scene.models.front().set(voxel, materials[ball]);
    });
    return scene;
}

/// The Voronoi cells of 24 random sites inside a ball.
Scene makeFoam() {
    constexpr int kSide = 44;
    constexpr int kCells = 24;
    constexpr std::int64_t kRadius = 410;  // twentieths of a voxel
    constexpr std::array<Rgba8, 8> kColors{{{231, 111, 81, 255},
                                            {244, 162, 97, 255},
                                            {233, 196, 106, 255},
                                            {138, 177, 125, 255},
                                            {42, 157, 143, 255},
                                            {69, 123, 157, 255},
                                            {109, 104, 117, 255},
                                            {229, 152, 155, 255}}};
    Scene scene = emptySample(Vec3i::Constant(kSide), "foam");
    std::vector<Vec3i> sites;
    const Vec3i middle = Vec3i::Constant(5 * kSide);  // tenths
    for (int i = 0; i < kCells; ++i) {
        const auto coordinate = [&](int axis) {
            return static_cast<int>(hashCell(i, axis, 0, 31) % (8U * kSide)) + kSide;
        };
        sites.emplace_back(coordinate(0), coordinate(1), coordinate(2));
        Rgba8 color = kColors[static_cast<std::size_t>(i) % kColors.size()];
        for (std::size_t c = 0; c < 3; ++c)
            color[c] = static_cast<std::uint8_t>(color[c] - 22 * (i / 8));
        scene.materials.push_back({.source = static_cast<std::uint32_t>(i + 1), .color = color});
    }
    forEachCell(scene.models.front().size(), [&](const Vec3i& voxel) {
        if (distance2(voxel, middle) < kRadius * kRadius)
            scene.models.front().set(
                voxel, MaterialId{static_cast<std::uint16_t>(nearest(voxel, sites) + 1)});
    });
    return scene;
}

/// Every second voxel of a cube: no two share a face, so every pointel inside is non-manifold.
Scene makeCheckerboard() {
    Scene scene = emptySample(Vec3i::Constant(8), "checkerboard");
    const MaterialId light =
        addPaletteRow(scene, {.name = "board"}, {{228, 214, 186, 255}, {122, 78, 58, 255}});
    forEachCell(scene.models.front().size(), [&](const Vec3i& voxel) {
        if (voxel.sum() % 2 == 0)
            scene.models.front().set(voxel, nextMaterial(light, voxel.z() / 2 % 2));
    });
    return scene;
}

Scene makeVoxel() {
    Scene scene = emptySample(Vec3i::Ones(), "voxel");
    const MaterialId material = addPaletteRow(scene, {.name = "voxel"}, {{214, 106, 82, 255}});
    scene.models.front().set(Vec3i::Zero(), material);
    return scene;
}

}  // namespace rivage::core
