#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace rivage::client {

using Triangle = std::array<Eigen::Vector3d, 3>;

/// Twice the area as a vector along the normal.
[[nodiscard]] inline Eigen::Vector3d areaNormal(const Triangle& t) {
    return (t[1] - t[0]).cross(t[2] - t[0]);
}

/// The point of a segment that is closest to `p`.
[[nodiscard]] inline Eigen::Vector3d closestOnSegment(const Eigen::Vector3d& p,
                                                      const Eigen::Vector3d& a,
                                                      const Eigen::Vector3d& b) {
    const Eigen::Vector3d along = b - a;
    const double length2 = along.squaredNorm();
    if (!(length2 > 0)) return a;
    const double at = (p - a).dot(along) / length2;
    return at <= 0 ? a : at >= 1 ? b : Eigen::Vector3d(a + at * along);
}

/// The point of a triangle that is closest to `p`. Holds for slivers too: whenever the foot of the
/// perpendicular is not clearly inside, the edges decide.
[[nodiscard]] inline Eigen::Vector3d closestOnTriangle(const Eigen::Vector3d& p,
                                                       const Triangle& t) {
    const Eigen::Vector3d normal = areaNormal(t);
    Eigen::Vector3d best = p;
    double best2 = -1;
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d& a = t[i];
        const Eigen::Vector3d& b = t[(i + 1) % 3];
        if (normal.cross(b - a).dot(p - a) > 0) continue;  // inside of this edge
        const Eigen::Vector3d point = closestOnSegment(p, a, b);
        const double distance2 = (point - p).squaredNorm();
        if (best2 < 0 || distance2 < best2) {
            best = point;
            best2 = distance2;
        }
    }
    if (best2 >= 0) return best;
    return p - normal * (normal.dot(p - t[0]) / normal.squaredNorm());
}

/// The weights of the corners that give a point of the triangle, none of them negative.
[[nodiscard]] inline Eigen::Vector3d weightsIn(const Triangle& t, const Eigen::Vector3d& point) {
    const Eigen::Vector3d normal = areaNormal(t);
    Eigen::Vector3d weights;
    for (int i = 0; i < 3; ++i) {
        const Eigen::Vector3d& a = t[(i + 1) % 3];
        weights[i] = std::max(0.0, (t[(i + 2) % 3] - a).cross(point - a).dot(normal));
    }
    const double sum = weights.sum();
    return sum > 0 ? Eigen::Vector3d(weights / sum) : Eigen::Vector3d::Constant(1.0 / 3);
}

}  // namespace rivage::client
