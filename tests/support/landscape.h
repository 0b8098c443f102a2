#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "tests/support/grids.h"

/// Grids that are hard to close: they touch the border, or have voxels that touch in any way.
namespace rivage::test {

/// Hills and valleys (label 1) with a sea (label 2) up to a level, 64 x 68 x 40. Both reach the
/// floor and the walls of the grid.
inline VoxelGrid landscapeGrid() {
    constexpr double kLevel = 16;
    const auto wave = [](double t) { return std::sin(2 * M_PI * t); };
    return makeGrid({64, 68, 40}, 2, [&](const Vec3i& v) {
        const Vec3d p = v.cast<double>() + Vec3d::Constant(0.5);
        const double bumps = 2 * wave(p.x() / 48 + 0.05) * wave(p.y() / 51 + 0.1) +
                             wave(p.x() / 21 + p.y() / 37) + wave(p.y() / 17 - p.x() / 29 + 0.3);
        if (p.z() <= 14 + 2.5 * bumps) return 1;
        return p.z() <= kLevel ? 2 : 0;
    });
}

/// A grid from `makeGrid` in which some voxels, at random, take a random label or none.
inline VoxelGrid speckledGrid(VoxelGrid grid, int percent, std::uint32_t seed = 1) {
    std::mt19937 random(seed);
    const Vec3i size = grid.voxels.size();
    const auto labels = static_cast<std::uint32_t>(grid.labels.size());
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x)
                if (static_cast<int>(random() % 100) < percent)
                    grid.voxels.set({x, y, z}, static_cast<MaterialId>(random() % labels));
    return grid;
}

}  // namespace rivage::test
