#include <algorithm>
#include <cmath>
#include <vector>

#include "core/samples/sample_scenes.h"

/// The island: a height field over the whole box, land below it, water above it up to the level
/// of the sea. Only + - * / and floor are used on fractions, so every machine gets the same one.
namespace rivage::core {
namespace {

constexpr int kWide = 64;
constexpr int kDeep = 68;
constexpr int kTall = 40;
constexpr int kSeaLevel = 11;  // voxels of the box below the surface of the water

double smoothStep(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// Smooth noise in 0..1 from random values on a lattice of spacing `step`.
double valueNoise(double x, double y, double step, std::uint32_t seed) {
    const double u = x / step;
    const double v = y / step;
    const int i = static_cast<int>(std::floor(u));
    const int j = static_cast<int>(std::floor(v));
    const double fu = smoothStep(0, 1, u - i);
    const double fv = smoothStep(0, 1, v - j);
    const auto corner = [&](int di, int dj) {
        return hashCell(i + di, j + dj, 0, seed) * (1.0 / 4294967296.0);
    };
    const double near = corner(0, 0) * (1 - fu) + corner(1, 0) * fu;
    const double far = corner(0, 1) * (1 - fu) + corner(1, 1) * fu;
    return near * (1 - fv) + far * fv;
}

/// A round bump of this height with a flat top and a flat foot.
double bump(double x, double y, double cx, double cy, double radius, double height) {
    const double dx = (x - cx) / radius;
    const double dy = (y - cy) / radius;
    const double q = std::min(1.0, dx * dx + dy * dy);
    return height * (1 - q) * (1 - q) * (1 + 0.5 * q);
}

/// Height of the land above the floor of the box, voxels.
double landHeight(double x, double y) {
    const double wx = x + 5 * (valueNoise(x, y, 15, 11) - 0.5);
    const double wy = y + 5 * (valueNoise(x, y, 15, 12) - 0.5);
    const double ex = (wx - 32) / 27.5;
    const double ey = (wy - 35) / 29;
    double height = 3.5 + 2.2 * valueNoise(x, y, 11, 13);
    height += 10.4 * (1 - smoothStep(0.42, 1.08, ex * ex + ey * ey));
    height += bump(wx, wy, 24, 44, 22, 24.9);  // the mountain
    height += bump(wx, wy, 44, 51, 11, 5);     // its shoulder
    height += bump(wx, wy, 47, 27, 12, 6.5);   // the hill beyond the bay
    height -= bump(wx, wy, 28, 10, 19, 13.5);  // the bay
    height += 2.4 * (valueNoise(x, y, 6, 14) - 0.5) * smoothStep(10, 20, height);
    return std::clamp(height, 2.0, static_cast<double>(kTall));
}

class Island {
public:
    Island() : scene_(emptySample(Vec3i(kWide, kDeep, kTall), "island")) {
        const Material water{.kind = MaterialClass::glass,
                             .roughness = 0.08,
                             .transmission = 0.5,
                             .ior = 1.33,
                             .name = "sea"};
        sea_ = addPaletteRow(
            scene_, water,
            {{104, 205, 208, 255}, {52, 160, 190, 255}, {28, 112, 160, 255}, {18, 78, 128, 255}});
        sand_ = addPaletteRow(scene_, {.name = "sand"},
                              {{238, 217, 164, 255}, {222, 196, 138, 255}, {178, 158, 118, 255}});
        grass_ = addPaletteRow(scene_, {.name = "grass"},
                               {{140, 186, 84, 255}, {108, 162, 70, 255}, {76, 132, 62, 255}});
        rock_ =
            addPaletteRow(scene_, {.name = "rock"}, {{146, 132, 118, 255}, {118, 108, 102, 255}});
        snow_ =
            addPaletteRow(scene_, {.name = "snow"}, {{246, 248, 250, 255}, {220, 228, 236, 255}});
        earth_ =
            addPaletteRow(scene_, {.name = "earth"}, {{134, 100, 72, 255}, {104, 78, 60, 255}});
        for (int y = 0; y < kDeep; ++y)
            for (int x = 0; x < kWide; ++x) land_.push_back(landHeight(x + 0.5, y + 0.5));
    }

    Scene build() && {
        BrickGrid& grid = scene_.models.front();
        for (int y = 0; y < kDeep; ++y)
            for (int x = 0; x < kWide; ++x) {
                const int height = heightAt(x, y);
                for (int z = 0; z < height; ++z) grid.set(Vec3i(x, y, z), landAt(x, y, z));
                for (int z = height; z < kSeaLevel; ++z) grid.set(Vec3i(x, y, z), waterAt(x, y, z));
            }
        return std::move(scene_);
    }

private:
    [[nodiscard]] static std::size_t columnOf(int x, int y) {
        return static_cast<std::size_t>(x) + static_cast<std::size_t>(kWide) * y;
    }
    [[nodiscard]] int heightAt(int x, int y) const {
        x = std::clamp(x, 0, kWide - 1);
        y = std::clamp(y, 0, kDeep - 1);
        return static_cast<int>(std::floor(land_[columnOf(x, y)] + 0.5));
    }
    /// Steepest step to a neighbouring column two voxels away.
    [[nodiscard]] int slopeAt(int x, int y) const {
        const int dx = std::abs(heightAt(x + 2, y) - heightAt(x - 2, y));
        const int dy = std::abs(heightAt(x, y + 2) - heightAt(x, y - 2));
        return std::max(dx, dy);
    }
    /// 0..255, one value a cell: dithers where two bands meet.
    [[nodiscard]] static int grain(int x, int y, int z) {
        return static_cast<int>(hashCell(x, y, z, 21) >> 24);
    }

    [[nodiscard]] MaterialId landAt(int x, int y, int z) const {
        const int height = heightAt(x, y);
        const int dither = grain(x, y, z);
        const int below = height - 1 - z;  // under the surface of the ground
        if (below > 3) return nextMaterial(earth_, z + (dither > 200) < 5 ? 1 : 0);
        const int above = height - 1 - kSeaLevel;  // the top voxel over the sea
        const int band = above + (dither > 170 ? 1 : 0) - (dither < 60 ? 1 : 0);
        if (above < -2) return nextMaterial(sand_, dither > 190 ? 1 : 2);
        if (band < 2) return nextMaterial(sand_, dither > 215 ? 1 : 0);
        const bool steep = slopeAt(x, y) >= (above > 8 ? 6 : 7);
        if (band >= 21) return nextMaterial(snow_, dither > 205 ? 1 : 0);
        if (steep || band >= 17) return nextMaterial(rock_, dither > 150 ? 1 : 0);
        return nextMaterial(grass_, band < 4 ? 0 : band < 10 ? 1 : 2);
    }
    /// Bands of depth, taken from the whole column, so that the shallows shine.
    [[nodiscard]] MaterialId waterAt(int x, int y, int z) const {
        const double land = land_[columnOf(x, y)];
        const double depth = kSeaLevel - land + grain(x, y, z) * (0.6 / 255) - 0.3;
        return nextMaterial(sea_, depth < 2 ? 0 : depth < 4 ? 1 : depth < 6.6 ? 2 : 3);
    }

    Scene scene_;
    MaterialId sea_, sand_, grass_, rock_, snow_, earth_;
    std::vector<double> land_;  ///< height of the ground by column, x fastest
};

}  // namespace

Scene makeIsland() { return Island().build(); }

}  // namespace rivage::core
