#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/surface/digital_surface.h"
#include "tests/support/grids.h"

/// Solids whose distance, normal and edges are known, in the units of their parameters.
namespace rivage::test {

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();
inline constexpr Label kBackground{0};

struct Box {
    Vec3d center;
    Vec3d halfSides;
    Mat3d axes;  // columns

    [[nodiscard]] Vec3d local(const Vec3d& p) const { return axes.transpose() * (p - center); }
    [[nodiscard]] double distance(const Vec3d& p) const {
        const Vec3d outside = local(p).cwiseAbs() - halfSides;
        return outside.cwiseMax(0.0).norm() + std::min(outside.maxCoeff(), 0.0);
    }
    [[nodiscard]] Vec3d normal(const Vec3d& p) const {
        const Vec3d q = local(p);
        int axis = 0;
        (q.cwiseAbs() - halfSides).maxCoeff(&axis);
        return axes.col(axis) * (q[axis] > 0 ? 1.0 : -1.0);
    }
    /// To the planes of the two nearest faces: exact beside an edge.
    [[nodiscard]] double edge(const Vec3d& p) const {
        Vec3d fromPlanes = (local(p).cwiseAbs() - halfSides).cwiseAbs();
        std::sort(fromPlanes.begin(), fromPlanes.end());
        return fromPlanes.head<2>().norm();
    }
};

/// The interfaces of `sectorGrid` with 3 labels. Half-plane t is where sector t (of 0, 1, 2) begins
/// and the one before it ends; label l is sector l - 1.
struct Sectors {
    SectorFrame frame;
    double radius;

    [[nodiscard]] Vec3d direction(int t) const {
        const double angle = (t / 3.0 - 0.5) * 2 * M_PI;
        return frame.u * std::cos(angle) + frame.w * std::sin(angle);
    }
    [[nodiscard]] static int halfPlane(const LabelPair& labels) {
        return index(labels.inner) == 1 && index(labels.outer) == 3 ? 0 : index(labels.inner);
    }
    [[nodiscard]] double distance(const LabelPair& labels, const Vec3d& p) const {
        const Vec3d q = p - frame.centre;
        return labels.outer == kBackground ? q.norm() - radius : normal(labels, p).dot(q);
    }
    [[nodiscard]] Vec3d normal(const LabelPair& labels, const Vec3d& p) const {
        if (labels.outer == kBackground) return (p - frame.centre).normalized();
        const int t = halfPlane(labels);
        // Labels grow with the turn, but for half-plane 0.
        return frame.axis.cross(direction(t)) * (t == 0 ? -1.0 : 1.0);
    }
    /// To the arc where half-plane t meets the sphere.
    [[nodiscard]] double arc(int t, const Vec3d& q) const {
        const Vec3d along = direction(t);
        if (q.dot(along) <= 0) return kInfinite;
        return std::hypot(frame.axis.cross(along).dot(q), q.norm() - radius);
    }
    [[nodiscard]] double edge(const LabelPair& labels, const Vec3d& p) const {
        const Vec3d q = p - frame.centre;
        const int sector = index(labels.inner) - 1;
        if (labels.outer == kBackground) return std::min(arc(sector, q), arc((sector + 1) % 3, q));
        return std::min(arc(halfPlane(labels), q), frame.axis.cross(q).norm());
    }
};

}  // namespace rivage::test
