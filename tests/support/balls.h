#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "tests/support/grids.h"

namespace rivage::test {

/// Three touching balls in a grid of side^3, labels 1 to 3: a scene of any size with triple curves
/// and quadruple points. A voxel belongs to the nearest centre among the balls that contain its own
/// centre, ties to the first. Integer arithmetic, in units of 1/2000 of a voxel.
inline VoxelGrid ballsGrid(int side) {
    struct Ball {
        std::array<std::int64_t, 3> center;  // thousandths of the side
        std::int64_t radius;
    };
    static constexpr std::array<Ball, 3> kBalls{
        {{{361, 402, 423}, 262}, {{643, 437, 458}, 241}, {{497, 662, 583}, 253}}};
    return makeGrid(Vec3i::Constant(side), 3, [&](const Vec3i& voxel) {
        int label = 0;
        std::int64_t nearest = std::numeric_limits<std::int64_t>::max();
        for (int b = 0; b < 3; ++b) {
            std::int64_t squared = 0;
            for (int k = 0; k < 3; ++k) {
                const std::int64_t off =
                    1000 * (2 * std::int64_t{voxel[k]} + 1) - 2 * side * kBalls[b].center[k];
                squared += off * off;
            }
            const std::int64_t radius = 2 * side * kBalls[b].radius;
            if (squared > radius * radius || squared >= nearest) continue;
            nearest = squared;
            label = b + 1;
        }
        return label;
    });
}

}  // namespace rivage::test
