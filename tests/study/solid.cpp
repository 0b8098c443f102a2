#include "tests/study/solid.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rivage::study {
namespace {

using Vec2d = Eigen::Vector2d;

Foot footOf(const Vec3d& p, const Vec3d& normal, double distance) {
    return {p - distance * normal, normal, distance, kInfinite};
}

Vec2d rightOf(const Vec2d& v) { return {v.y(), -v.x()}; }
double cross(const Vec2d& a, const Vec2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The nearest point of a side; `normal` points away from the profile.
struct SideFoot {
    Vec2d at;
    Vec2d normal;
};

SideFoot footOnSegment(const Side& side, const Vec2d& p) {
    const Vec2d along = side.to - side.from;
    const double t = std::clamp((p - side.from).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return {side.from + t * along, rightOf(along).normalized()};
}

SideFoot footOnArc(const Side& side, const Vec2d& p) {
    const Vec2d a = side.from - side.center;
    const Vec2d b = side.to - side.center;
    const double turn = cross(a, b) > 0 ? 1 : -1;  // 1: the centre is inside
    const Vec2d d = p - side.center;
    const bool within = turn * cross(a, d) >= 0 && turn * cross(d, b) >= 0;
    const Vec2d spoke =
        within ? Vec2d(d.normalized() * a.norm()) : ((d - a).norm() < (d - b).norm() ? a : b);
    return {side.center + spoke, turn * spoke.normalized()};
}

SideFoot footOn(const Side& side, const Vec2d& p) {
    return side.isArc ? footOnArc(side, p) : footOnSegment(side, p);
}

/// The foot on a whole profile, and the distance, negative inside.
struct ProfileFoot {
    Vec2d at = Vec2d::Zero();
    Vec2d normal = Vec2d::Zero();
    double distance = kInfinite;
};

ProfileFoot footOnProfile(const std::vector<Side>& profile, const Vec2d& p) {
    constexpr double kSame = 1e-9;
    ProfileFoot best;
    Vec2d normals = Vec2d::Zero();  // of all sides that share the foot
    double steepest = -2;
    for (const Side& side : profile) {
        const SideFoot foot = footOn(side, p);
        const double distance = (p - foot.at).norm();
        if (distance > best.distance + kSame) continue;
        if (distance < best.distance - kSame) {
            normals.setZero();
            steepest = -2;
            best.distance = distance;
            best.at = foot.at;
        }
        normals += foot.normal;
        const double facing = foot.normal.dot(p - foot.at) / std::max(distance, kSame);
        if (facing <= steepest) continue;
        steepest = facing;
        best.normal = foot.normal;
    }
    // At a corner the sum of both normals tells the sides apart.
    if (normals.dot(p - best.at) < 0) best.distance = -best.distance;
    return best;
}

/// Newton steps along the gradient until the surface is reached.
Vec3d land(const Implicit& surface, Vec3d q) {
    constexpr double kLongest = 0.1;  // of a step; shapes have a radius of 0.4
    constexpr double kReached = 1e-12;
    for (int k = 0; k < 50; ++k) {
        const Vec3d gradient = surface.gradient(q);
        const double square = std::max(gradient.squaredNorm(), 1e-24);
        Vec3d step = -surface.value(q) / square * gradient;
        if (step.norm() > kLongest) step *= kLongest / step.norm();
        q += step;
        if (step.norm() < kReached) break;
    }
    return q;
}

Foot footOnImplicit(const Implicit& surface, const Vec3d& p) {
    constexpr double kStill = 1e-9;
    Vec3d q = land(surface, p);
    Vec3d normal = surface.gradient(q).normalized();
    for (int k = 0; k < 100; ++k) {
        Vec3d along = p - q;
        along -= normal.dot(along) * normal;
        if (along.norm() < kStill) break;
        q = land(surface, q + along);
        normal = surface.gradient(q).normalized();
    }
    const double sign = surface.value(p) <= 0 ? -1 : 1;
    return {q, normal, sign * (p - q).norm(), kInfinite};
}

/// Nearest point of what is in both, for a point outside both.
Vec3d projectOnBoth(const Solid& a, const Solid& b, const Vec3d& p) {
    const auto projected = [](const Solid& solid, const Vec3d& x) -> Vec3d {
        const Foot foot = solid(x);
        return foot.distance > 0 ? foot.at : x;
    };
    Vec3d x = p;
    Vec3d overA = Vec3d::Zero();
    Vec3d overB = Vec3d::Zero();
    for (int k = 0; k < 50; ++k) {
        const Vec3d onA = projected(a, x + overA);
        overA = x + overA - onA;
        const Vec3d onB = projected(b, onA + overB);
        overB = onA + overB - onB;
        const double step = (onB - x).norm();
        x = onB;
        if (step < 1e-10) break;
    }
    return x;
}

/// From a point to the line where the tangent planes of two feet meet.
double toCrease(const Foot& a, const Foot& b) {
    const double cosine = a.normal.dot(b.normal);
    const double sine2 = 1 - cosine * cosine;
    if (sine2 < 1e-6) return kInfinite;
    const double square =
        a.distance * a.distance + b.distance * b.distance - 2 * a.distance * b.distance * cosine;
    return std::sqrt(std::max(square, 0.0) / sine2);
}

}  // namespace

Solid ball(const Vec3d& center, double radius) {
    return [=](const Vec3d& p) {
        return footOf(p, (p - center).normalized(), (p - center).norm() - radius);
    };
}

Solid halfSpace(const Vec3d& through, const Vec3d& normal) {
    return [=](const Vec3d& p) { return footOf(p, normal, normal.dot(p - through)); };
}

Solid box(const Vec3d& low, const Vec3d& high) {
    const Box exact{0.5 * (low + high), 0.5 * (high - low), Mat3d::Identity()};
    return [=](const Vec3d& p) {
        const double distance = exact.distance(p);
        const Vec3d normal = exact.normal(p);
        const Vec3d at =
            distance > 0 ? Vec3d(p.cwiseMax(low).cwiseMin(high)) : Vec3d(p - distance * normal);
        return Foot{at, normal, distance, exact.edge(p)};
    };
}

Solid capsule(double half, double radius) {
    return [=](const Vec3d& p) {
        const Vec3d core(0, 0, std::clamp(p.z(), -half, half));
        return footOf(p, (p - core).normalized(), (p - core).norm() - radius);
    };
}

Solid torus(double major, double minor) {
    return [=](const Vec3d& p) {
        const Vec3d flat(p.x(), p.y(), 0);
        const Vec3d core = flat * (major / flat.norm());
        return footOf(p, (p - core).normalized(), (p - core).norm() - minor);
    };
}

Solid implicit(const Implicit& surface) {
    return [=](const Vec3d& p) { return footOnImplicit(surface, p); };
}

Solid intersection(Solid a, Solid b) {
    return [a = std::move(a), b = std::move(b)](const Vec3d& p) {
        const Foot onA = a(p);
        const Foot onB = b(p);
        Foot foot = onA.distance > onB.distance ? onA : onB;
        foot.edge = std::min({onA.edge, onB.edge, toCrease(onA, onB)});
        if (onA.distance > 0 && onB.distance > 0) {
            foot.at = projectOnBoth(a, b, p);
            foot.distance = (p - foot.at).norm();
        }
        return foot;
    };
}

Solid extrusion(std::vector<Side> profile, double half, std::vector<Vec2d> creases) {
    return [=, profile = std::move(profile), creases = std::move(creases)](const Vec3d& p) {
        const Vec2d flat = p.head<2>();
        const ProfileFoot foot = footOnProfile(profile, flat);
        const double sign = p.z() > 0 ? 1 : -1;
        const double over = std::abs(p.z()) - half;
        Foot result;
        const bool facesSide = foot.distance > over;
        result.normal = facesSide ? Vec3d(foot.normal.x(), foot.normal.y(), 0) : Vec3d(0, 0, sign);
        const bool movesFlat = foot.distance > 0 || (facesSide && over <= 0);
        const bool movesUp = over > 0 || !facesSide;
        const Vec2d at = movesFlat ? foot.at : flat;
        result.at = {at.x(), at.y(), movesUp ? sign * half : p.z()};
        const bool inside = foot.distance <= 0 && over <= 0;
        result.distance = (p - result.at).norm() * (inside ? -1 : 1);
        result.edge = std::hypot(foot.distance, over);
        for (const Vec2d& corner : creases)
            result.edge =
                std::min(result.edge, std::hypot((flat - corner).norm(), std::max(over, 0.0)));
        return result;
    };
}

Solid turned(Solid inner, const Mat3d& axes) {
    return [inner = std::move(inner), axes](const Vec3d& p) {
        Foot foot = inner(axes.transpose() * p);
        foot.at = axes * foot.at;
        foot.normal = axes * foot.normal;
        return foot;
    };
}

}  // namespace rivage::study
