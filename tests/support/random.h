#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/base/vec.h"

/// Random numbers that are the same with every standard library.
namespace rivage::test {

/// Uniform in (0, 1).
inline double unitDraw(std::mt19937& random) {
    return (static_cast<double>(random()) + 0.5) / 4294967296.0;
}

/// From the normal distribution (Box and Muller).
inline double gaussian(std::mt19937& random) {
    const double length = std::sqrt(-2 * std::log(unitDraw(random)));
    return length * std::cos(2 * M_PI * unitDraw(random));
}

/// Uniform among all rotations: a direction in four dimensions.
inline core::Mat3d randomRotation(std::mt19937& random) {
    for (;;) {
        Eigen::Vector4d q;
        for (double& x : q) x = 2 * (static_cast<double>(random()) / 4294967296.0) - 1;
        const double length = q.norm();
        if (length > 1 || length < 0.1) continue;
        return Eigen::Quaterniond(q / length).toRotationMatrix();
    }
}

}  // namespace rivage::test
