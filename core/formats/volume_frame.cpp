#include "core/formats/volume_frame.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace rivage::core {
namespace {

/// Which axis of space each axis of the file is nearest to; the three together, so that no two take
/// the same one.
std::array<int, 3> nearestAxes(const VolumeSteps& unit) {
    std::array<int, 3> order{0, 1, 2};
    std::array<int, 3> best = order;
    double most = -1;
    do {
        double sum = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) sum += std::abs(unit[axis][order[axis]]);
        if (sum > most + 1e-12) {
            most = sum;
            best = order;
        }
    } while (std::next_permutation(order.begin(), order.end()));
    return best;
}

bool sameWay(const VolumeSteps& unit) {
    constexpr double kFlat = 1e-3;
    Mat3d columns;
    columns << unit[0], unit[1], unit[2];
    return std::abs(columns.determinant()) < kFlat;
}

/// The largest angle between an axis of the file and the axis of space that it is taken for, degrees.
double turnOf(const VolumeSteps& unit, const std::array<int, 3>& axes) {
    double least = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
        least = std::min(least, std::abs(unit[axis][axes[axis]]));
    return std::acos(std::min(least, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace

Result<void> placeVolume(Scene& scene, const VolumeSteps& steps, const std::string& field) {
    VolumeSteps unit;
    Vec3d sides;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        sides[static_cast<int>(axis)] = steps[axis].norm();
        unit[axis] = steps[axis] / sides[static_cast<int>(axis)];
    }
    if (!sides.allFinite() || sides.minCoeff() <= 0 || sameWay(unit))
        return fail(ErrorCode::malformedInput, "the axes of the volume span no space", field);
    if (sides.maxCoeff() > kMaxSpacingRatio * sides.minCoeff())
        return fail(ErrorCode::malformedInput,
                    "the sides of a voxel differ by more than 100 times; the largest that is taken "
                    "as a ratio is 100",
                    field);
    const std::array<int, 3> axes = nearestAxes(unit);
    Instance& instance = scene.instances.front();
    instance.rotation = Mat3i::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const int column = static_cast<int>(axis);
        instance.rotation(axes[axis], column) = unit[axis][axes[axis]] < 0 ? -1 : 1;
        // To a millionth: files keep them as floats, and as squares in the elements of a rotation.
        constexpr double kExact = 1e6;
        scene.spacing[axes[axis]] = std::round(sides[column] / sides.minCoeff() * kExact) / kExact;
    }
    constexpr double kStraight = 0.1;
    if (const double turn = turnOf(unit, axes); turn > kStraight) {
        std::array<char, 96> text;
        std::snprintf(text.data(), text.size(),
                      "the volume is turned by %.1f degrees; the surface keeps its own axes", turn);
        scene.warnings.emplace_back(text.data());
    }
    return {};
}

}  // namespace rivage::core
