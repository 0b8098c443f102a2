#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "core/samples/sample_scenes.h"

/// A house: a hollow box of plaster on a stone base, a pitched roof with eaves, a door, two
/// windows of glass to every side with a frame around them, a chimney, and a lit lamp at the door.
namespace rivage::core {
namespace {

constexpr int kX = 36;  // the whole scene
constexpr int kY = 30;
constexpr int kZ = 34;
constexpr int kMargin = 4;    // garden around the walls
constexpr int kGround = 2;    // top of the lawn
constexpr int kWallTop = 16;  // where the roof begins
constexpr int kWall = 2;      // thickness

struct House {
    House() : scene(emptySample(Vec3i(kX, kY, kZ), "house")) {
        lawn = addPaletteRow(scene, {.name = "lawn"}, {{122, 168, 82, 255}, {104, 150, 72, 255}});
        stone =
            addPaletteRow(scene, {.name = "stone"}, {{148, 144, 138, 255}, {126, 122, 118, 255}});
        plaster =
            addPaletteRow(scene, {.name = "plaster"}, {{238, 226, 200, 255}, {230, 216, 188, 255}});
        tiles = addPaletteRow(scene, {.name = "tiles"}, {{176, 78, 58, 255}, {158, 66, 50, 255}});
        wood = addPaletteRow(scene, {.name = "wood"}, {{112, 74, 48, 255}, {240, 236, 228, 255}});
        pane = addPaletteRow(scene,
                             {.kind = MaterialClass::glass,
                              .roughness = 0.05,
                              .transmission = 0.8,
                              .ior = 1.5,
                              .name = "windows"},
                             {{168, 206, 224, 255}});
        lamp = addPaletteRow(scene,
                             {.kind = MaterialClass::emissive,
                              .roughness = 0.5,
                              .emission = 0.8,
                              .emissiveStrength = 4,
                              .name = "lamp"},
                             {{255, 214, 130, 255}});
    }

    void set(int x, int y, int z, MaterialId material) {
        scene.models.front().set(Vec3i(x, y, z), material);
    }
    /// Fills a box, ends excluded, with two shades of a material.
    void fill(const Vec3i& low, const Vec3i& high, MaterialId material, bool shades) {
        for (int z = low.z(); z < high.z(); ++z)
            for (int y = low.y(); y < high.y(); ++y)
                for (int x = low.x(); x < high.x(); ++x)
                    set(x, y, z,
                        nextMaterial(material, shades && hashCell(x, y, z, 41) % 4 == 0 ? 1 : 0));
    }

    Scene scene;
    MaterialId lawn, stone, plaster, tiles, wood, pane, lamp;
};

void buildWalls(House& house) {
    const Vec3i low(kMargin, kMargin, kGround);
    const Vec3i high(kX - kMargin, kY - kMargin, kWallTop);
    house.fill(Vec3i(0, 0, 0), Vec3i(kX, kY, kGround), house.lawn, true);
    house.fill(low, high, house.plaster, true);
    house.fill(low, Vec3i(high.x(), high.y(), kGround + 2), house.stone, true);
    const Vec3i inset(kWall, kWall, 1);  // a floor stays
    house.fill(low + inset, high - Vec3i(kWall, kWall, 0), MaterialId{0}, false);
}

/// The roof rises one voxel a voxel from both eaves; the gables below it are walls.
void buildRoof(House& house) {
    constexpr int kEaves = 2;
    for (int y = kMargin - kEaves; y < kY - kMargin + kEaves; ++y) {
        const int inward = std::min(y - (kMargin - kEaves), kY - kMargin + kEaves - 1 - y);
        const int top = kWallTop - kEaves + inward;
        for (int x = kMargin - kEaves; x < kX - kMargin + kEaves; ++x) {
            const bool gable = (x >= kMargin && x < kMargin + kWall) ||
                               (x < kX - kMargin && x >= kX - kMargin - kWall);
            if (gable)
                for (int z = kWallTop; z < top; ++z) house.set(x, y, z, house.plaster);
            for (int z = top; z < top + kWall; ++z)
                house.set(x, y, z, nextMaterial(house.tiles, (x + 2 * inward) / 2 % 2));
        }
    }
}

/// A window in the wall whose outer side faces along `axis`; `at` is its low corner.
void buildWindow(House& house, const Vec3i& at, int axis) {
    constexpr int kWide = 5;
    constexpr int kHigh = 6;
    for (int h = 0; h < kHigh; ++h)
        for (int w = 0; w < kWide; ++w)
            for (int d = 0; d < kWall; ++d) {
                const Vec3i along = axis == 0 ? Vec3i(d, w, h) : Vec3i(w, d, h);
                const Vec3i cell = at + along;
                const bool frame = h == 0 || h == kHigh - 1 || w == 0 || w == kWide - 1;
                house.set(cell.x(), cell.y(), cell.z(),
                          frame ? nextMaterial(house.wood, 1) : house.pane);
            }
}

void buildOpenings(House& house) {
    constexpr int kSill = kGround + 5;
    const int back = kY - kMargin - kWall;
    const int right = kX - kMargin - kWall;
    for (const int x : {7, 24}) {
        buildWindow(house, Vec3i(x, kMargin, kSill), 1);
        buildWindow(house, Vec3i(x, back, kSill), 1);
    }
    for (const int y : {6, 19}) {
        buildWindow(house, Vec3i(kMargin, y, kSill), 0);
        buildWindow(house, Vec3i(right, y, kSill), 0);
    }
    house.fill(Vec3i(15, kMargin - 1, kGround), Vec3i(21, kMargin, kGround + 1), house.stone, true);
    house.fill(Vec3i(15, kMargin, kGround), Vec3i(21, kMargin + kWall, kGround + 10), house.wood,
               false);
    house.fill(Vec3i(22, kMargin - 1, kGround + 8), Vec3i(23, kMargin, kGround + 10), house.lamp,
               false);
    house.fill(Vec3i(16, 0, kGround - 1), Vec3i(20, kMargin - 1, kGround), house.stone, true);
}

void buildChimney(House& house) {
    house.fill(Vec3i(24, 17, kWallTop + 2), Vec3i(29, 22, kZ), house.stone, true);
    house.fill(Vec3i(25, 18, kZ - 3), Vec3i(28, 21, kZ), MaterialId{0}, false);
}

}  // namespace

Scene makeHouse() {
    House house;
    buildWalls(house);
    buildRoof(house);
    buildOpenings(house);
    buildChimney(house);
    return std::move(house.scene);
}

}  // namespace rivage::core
