#pragma once

#include "tests/support/grids.h"

namespace rivage::test {

/// Goursat's polynomial 0.03 (x^4 + y^4 + z^4) - 2 (x^2 + y^2 + z^2) - 8 <= 0 on the integers, the
/// regression shape of this energy: 6089 voxels, 2454 surfels, 2456 pointels.
inline VoxelGrid goursatGrid() {
    static constexpr int kReach = 10;
    return makeGrid(Vec3i::Constant(2 * kReach + 1), 1, [](const Vec3i& v) {
        const Eigen::Array3d p = (v.array() - kReach).cast<double>();
        return 0.03 * p.pow(4).sum() - 2 * p.square().sum() - 8 <= 0;
    });
}

}  // namespace rivage::test
