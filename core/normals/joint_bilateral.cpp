#include "core/normals/joint_bilateral.h"

#include <Eigen/LU>
#include <cmath>

namespace rivage::core {
namespace {

/// Weighted moments of the trivial normals over offsets.
struct Moments {
    double weight = 0;
    Vec3d normal = Vec3d::Zero();
    Vec3d offset = Vec3d::Zero();
    Mat3d square = Mat3d::Zero();   // offset offset^T
    Mat3d product = Mat3d::Zero();  // normal offset^T

    void add(int axis, double sign, const Vec3d& at, double w) {
        weight += w;
        normal[axis] += sign * w;
        offset += w * at;
        square += w * at * at.transpose();
        product.row(axis) += sign * w * at.transpose();
    }
};

/// The value at offset 0 of the linear fit of the normals over the tangent plane.
Vec3d linearFit(const Moments& sums, double radius) {
    const Vec3d mean = sums.normal / sums.weight;
    const Vec3d at = sums.offset / sums.weight;
    const Mat3d square = sums.square / sums.weight - at * at.transpose();
    const Mat3d product = sums.product / sums.weight - mean * at.transpose();
    const Vec3d up = mean.normalized();
    const Mat3d tangent = Mat3d::Identity() - up * up.transpose();
    // A small ridge keeps narrow windows, which say nothing across, at the mean.
    const double ridge = 0.02 * radius * radius;
    const Mat3d spread = tangent * square * tangent + up * up.transpose() + ridge * tangent;
    const Vec3d step = tangent * (spread.inverse() * (tangent * at));
    return mean - tangent * (product * step);
}

}  // namespace

Vec3d bilateralNormal(const DigitalSurface& surface, const NormalField& guide, PatchWalker& walker,
                      SurfelId s, const BilateralWindow& window) {
    const Vec3d& own = guide[s];
    const double perSquare = -1 / (window.angle * window.angle);
    Moments sums;
    walker.walk(s, window.radius, [&](SurfelId g, const Vec3d& offset, double distance) {
        const int axis = surface.axis[g];
        const double weight = (1 - distance / window.radius) * surface.faceArea(axis) *
                              std::exp(perSquare * (guide[g] - own).squaredNorm());
        sums.add(axis, surface.innerIsLow[g] ? 1 : -1, offset, weight);
    });
    constexpr double kCancelled = 1e-6;
    const Vec3d mean = sums.normal / sums.weight;
    if (mean.norm() <= kCancelled) return own;
    const Vec3d normal = window.linear ? linearFit(sums, window.radius) : mean;
    return normal.norm() > kCancelled ? Vec3d(normal.normalized()) : own;
}

}  // namespace rivage::core
