#include "core/emboss/frames.h"

#include <array>
#include <cmath>
#include <numbers>

namespace rivage::core {
namespace {

constexpr double degrees(double angle) { return angle * std::numbers::pi / 180; }

/// Which of the eight directions (1, 0), (1, 1), .. a horizontal vector is nearest to. Ties at 22.5
/// degrees are off the slopes 1:2 (26.6) and 1:3 (18.4).
Vec3d horizontalStep(const Vec3d& normal) {
    constexpr double kHalf = std::numbers::sqrt2 / 2;
    static const std::array<Vec3d, 8> kSteps{
        Vec3d(1, 0, 0),  Vec3d(kHalf, kHalf, 0),   Vec3d(0, 1, 0),  Vec3d(-kHalf, kHalf, 0),
        Vec3d(-1, 0, 0), Vec3d(-kHalf, -kHalf, 0), Vec3d(0, -1, 0), Vec3d(kHalf, -kHalf, 0)};
    const double turn = std::round(std::atan2(normal.y(), normal.x()) / degrees(45));
    return kSteps[static_cast<std::size_t>(static_cast<int>(turn) + 8) % 8];
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
    if (slope < kDiagonal) return {right, uphill, true};
    if (slope > kWall) return {right, Vec3d::UnitZ()};
    return {right, (uphill + Vec3d::UnitZ()) * std::numbers::sqrt2 / 2, true};
}

}  // namespace rivage::core
