#pragma once

#include <algorithm>

#include "core/base/vec.h"

namespace rivage::core {

/// 0 up to `low`, 1 from `high` on, smooth between them.
[[nodiscard]] inline double smoothstep(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

/// The unit vector between two, `b` where they cancel.
[[nodiscard]] inline Vec3d blend(const Vec3d& a, const Vec3d& b, double share) {
    const Vec3d sum = (1 - share) * a + share * b;
    constexpr double kCancelled = 1e-6;
    return sum.norm() > kCancelled ? Vec3d(sum.normalized()) : b;
}

}  // namespace rivage::core
