#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/base/ids.h"
#include "core/base/vec.h"

namespace rivage::core {

/// The corner k, 0 or 1, from which the diagonal of a face runs: its triangles are
/// (k, k + 1, k + 2) and (k, k + 2, k + 3). It is the shorter diagonal; on a tie, the one that has
/// the first pointel of the face.
[[nodiscard]] inline std::uint32_t firstCorner(const std::array<PointelId, 4>& corners,
                                               const IdVector<PointelId, Vec3d>& positions) {
    const double even = (positions[corners[2]] - positions[corners[0]]).squaredNorm();
    const double odd = (positions[corners[3]] - positions[corners[1]]).squaredNorm();
    if (even != odd) return even < odd ? 0 : 1;
    const auto first = std::min_element(corners.begin(), corners.end());
    return static_cast<std::uint32_t>(first - corners.begin()) & 1U;
}

}  // namespace rivage::core
