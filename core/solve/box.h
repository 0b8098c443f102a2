#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/vec.h"

namespace rivage::core {

/// The box |d|_inf <= limit around a rest position, for one displacement. An infinite limit is no
/// box at all.
struct Box {
    double limit = std::numeric_limits<double>::infinity();

    [[nodiscard]] Vec3d project(const Vec3d& d) const { return d.cwiseMin(limit).cwiseMax(-limit); }
    /// True where a component lies on a side of the box, so that it is not free.
    [[nodiscard]] bool active(double d) const { return std::abs(d) >= limit; }
    /// True where all components are free.
    [[nodiscard]] bool inside(const Vec3d& d) const { return d.cwiseAbs().maxCoeff() < limit; }
    /// The gradient of the free components, 0 elsewhere.
    [[nodiscard]] Vec3d freeGradient(const Vec3d& d, const Vec3d& g) const {
        return masked(g, [&](int k) { return !active(d[k]); });
    }
    /// The gradient of the active components that want to leave their side, 0 elsewhere.
    [[nodiscard]] Vec3d choppedGradient(const Vec3d& d, const Vec3d& g) const {
        return masked(g, [&](int k) { return active(d[k]) && (d[k] > 0) == (g[k] > 0); });
    }
    /// `wanted`, or the largest t >= 0 for which d - t * direction stays in the box if that is less.
    [[nodiscard]] double feasibleStep(const Vec3d& d, const Vec3d& direction, double wanted) const {
        double step = wanted;
        for (int k = 0; k < 3; ++k)
            if (std::abs(d[k] - wanted * direction[k]) > limit)
                step = std::min(step, (d[k] + (direction[k] > 0 ? limit : -limit)) / direction[k]);
        return step;
    }

private:
    template <typename Keep>
    static Vec3d masked(const Vec3d& g, Keep&& keep) {
        return {keep(0) ? g[0] : 0, keep(1) ? g[1] : 0, keep(2) ? g[2] : 0};
    }
};

}  // namespace rivage::core
