#pragma once

#include <cstdint>
#include <string>

#include "core/grid/scene.h"

/// What the sample scenes share, and one maker for each of them.
namespace rivage::core {

/// A .vox file names rows of eight palette entries, so each named group of colours starts a row.
inline constexpr std::uint16_t kPaletteRow = 8;

/// A scene of one empty model that stands on the ground, centred above the origin.
[[nodiscard]] Scene emptySample(const Vec3i& size, const std::string& name);

/// Appends colours as one palette row; `like` gives everything but the colour.
/// @return the id of the first of them
MaterialId addPaletteRow(Scene& scene, const Material& like, std::initializer_list<Rgba8> colors);

/// The `offset`-th material after `first`.
[[nodiscard]] constexpr MaterialId nextMaterial(MaterialId first, int offset) {
    return MaterialId{static_cast<std::uint16_t>(index(first) + offset)};
}

/// A well-mixed number of three coordinates and a seed, the same everywhere.
[[nodiscard]] std::uint32_t hashCell(int x, int y, int z, std::uint32_t seed);

Scene makeIsland();
Scene makeSphere();
Scene makeTorus();
Scene makeRotatedBox();
Scene makeBalls();
Scene makeFoam();
Scene makeHouse();
Scene makeBarn();
Scene makeCheckerboard();
Scene makeVoxel();

}  // namespace rivage::core
