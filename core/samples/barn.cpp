#include <cmath>

#include "core/samples/sample_scenes.h"

/// A barn with a barrel roof of tiles, walls of plaster and wood on a stone base, and a round tower
/// with a dome: flat and curved faces in plain colours, to show relief on.
namespace rivage::core {
namespace {

constexpr int kX = 58;  // the whole scene
constexpr int kY = 34;
constexpr int kZ = 40;
constexpr int kGround = 2;    // top of the lawn
constexpr int kWallTop = 14;  // where the barrel begins
constexpr int kTowerTop = 28;

struct Barn {
    Barn() : scene(emptySample(Vec3i(kX, kY, kZ), "barn")) {
        lawn = addPaletteRow(scene, {.name = "lawn"}, {{116, 158, 80, 255}});
        stone = addPaletteRow(scene, {.name = "stone"}, {{150, 146, 140, 255}});
        brick = addPaletteRow(scene, {.name = "brick"}, {{188, 120, 92, 255}});
        wood = addPaletteRow(scene, {.name = "wood"}, {{156, 112, 72, 255}});
        tiles = addPaletteRow(scene, {.name = "tiles"}, {{192, 88, 60, 255}});
    }
    Scene scene;
    MaterialId lawn, stone, brick, wood, tiles;
};

/// What the barn and its barrel roof put at a voxel, seen from the middle of their floor.
MaterialId ofHall(const Barn& barn, double x, double y, int z) {
    constexpr double kHalfLength = 19;
    constexpr double kHalfWidth = 11;
    constexpr double kRoof = 13;  // outer radius
    const double radius = std::hypot(y, z + 0.5 - (kWallTop - 2));
    const bool inside = std::abs(x) < kHalfLength && std::abs(y) < kHalfWidth;
    if (z >= kWallTop - 2 && std::abs(x) < kHalfLength + 2 && radius < kRoof)
        return std::abs(x) < kHalfLength && radius < kRoof - 2 ? barn.wood : barn.tiles;
    if (!inside || z >= kWallTop) return MaterialId{0};
    const bool door = x < -kHalfLength + 2 && std::abs(y) < 5 && z < kGround + 10;
    if (door || (std::abs(x + 4) < 5 && y < 0 && z < kGround + 9)) return barn.wood;
    return z < kGround + 3 ? barn.stone : barn.brick;
}

/// The same for the tower.
MaterialId ofTower(const Barn& barn, double x, double y, int z) {
    constexpr double kRadius = 8;
    constexpr double kDome = 9.6;
    const double around = std::hypot(x, y);
    const double above = z + 0.5 - kTowerTop;
    if (above >= 0) return std::hypot(around, above) < kDome ? barn.tiles : MaterialId{0};
    if (around >= kRadius) return MaterialId{0};
    return z < kGround + 3 ? barn.stone : barn.brick;
}

}  // namespace

Scene makeBarn() {
    Barn barn;
    BrickGrid& model = barn.scene.models.front();
    for (int z = 0; z < kZ; ++z)
        for (int y = 0; y < kY; ++y)
            for (int x = 0; x < kX; ++x) {
                const double alongY = y + 0.5 - kY / 2.0;
                MaterialId m = z < kGround ? barn.lawn : ofTower(barn, x + 0.5 - 46, alongY + 5, z);
                if (m == MaterialId{0}) m = ofHall(barn, x + 0.5 - 23, alongY - 1, z);
                model.set(Vec3i(x, y, z), m);
            }
    return std::move(barn.scene);
}

}  // namespace rivage::core
