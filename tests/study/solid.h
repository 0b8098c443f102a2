#pragma once

#include <functional>
#include <vector>

#include "tests/support/solids.h"

/// Solids whose surface is known exactly: the nearest point of it, its normal, and how far the
/// nearest crease is.
namespace rivage::study {

using namespace rivage::core;
using namespace rivage::test;

/// The place of a surface that is nearest to a point.
struct Foot {
    Vec3d at = Vec3d::Zero();
    Vec3d normal = Vec3d::Zero();  ///< outwards; beside a crease, of the side that the point faces
    double distance = 0;           ///< of the point, negative inside
    double edge = kInfinite;       ///< from the point to the nearest crease
};

using Solid = std::function<Foot(const Vec3d&)>;

Solid ball(const Vec3d& center, double radius);
/// The points p with normal . (p - through) <= 0.
Solid halfSpace(const Vec3d& through, const Vec3d& normal);
Solid box(const Vec3d& low, const Vec3d& high);
/// All points within `radius` of the segment from -half e_z to half e_z.
Solid capsule(double half, double radius);
/// Around the z axis.
Solid torus(double major, double minor);

/// value(p) <= 0. The nearest point is found by Newton steps onto the surface and steps along it;
/// exact where the point is nearer to the surface than its centres of curvature.
struct Implicit {
    std::function<double(const Vec3d&)> value;
    std::function<Vec3d(const Vec3d&)> gradient;
};
Solid implicit(const Implicit& surface);

/// What is in both. Outside both, the nearest point comes from alternating projections with
/// Dykstra's correction, which is exact for convex solids.
Solid intersection(Solid a, Solid b);

/// A side of a profile: a segment, or an arc of less than half a turn about `center`.
struct Side {
    Eigen::Vector2d from;
    Eigen::Vector2d to;
    bool isArc = false;
    Eigen::Vector2d center = Eigen::Vector2d::Zero();
};

/// A profile, counter-clockwise in the xy plane, swept from -half e_z to half e_z.
/// @param creases  corners of the profile where its direction jumps
Solid extrusion(std::vector<Side> profile, double half, std::vector<Eigen::Vector2d> creases);

/// As seen after a change of axes: the solid is `inner` with its axes (x, y, z) laid along the
/// columns of `axes`.
Solid turned(Solid inner, const Mat3d& axes);

}  // namespace rivage::study
