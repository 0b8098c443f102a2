#include "core/emboss/frames.h"

#include <cmath>
#include <numbers>

namespace rivage::core {
namespace {

constexpr double degrees(double angle) { return angle * std::numbers::pi / 180; }

/// Which of the eight directions (1, 0), (1, 1), .. a horizontal vector is nearest to. Ties at 22.5
/// degrees are off the slopes 1:2 (26.6) and 1:3 (18.4).
Vec3d horizontalStep(const Vec3d& normal) {
    const double step = degrees(45);
    const double turn = step * std::round(std::atan2(normal.y(), normal.x()) / step);
    return {std::cos(turn), std::sin(turn), 0};
}

}  // namespace

TileFrame tileFrame(const Vec3d& normal) {
    constexpr double kLevel = degrees(10);  // roofs begin above it
    constexpr double kDiagonal = degrees(22.5);
    constexpr double kWall = degrees(67.5);
    const double slope = std::atan2(std::hypot(normal.x(), normal.y()), std::abs(normal.z()));
    if (slope < kLevel) return {};
    const Vec3d outwards = horizontalStep(normal);
    const Vec3d right(-outwards.y(), outwards.x(), 0);
    const Vec3d uphill = normal.z() > 0 ? Vec3d(-outwards) : outwards;
    if (slope < kDiagonal) return {right, uphill};
    if (slope > kWall) return {right, Vec3d::UnitZ()};
    return {right, (uphill + Vec3d::UnitZ()) * std::numbers::sqrt2 / 2};
}

}  // namespace rivage::core
