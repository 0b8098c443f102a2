#include "tests/study/bodies.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "tests/support/random.h"

namespace rivage::study {
namespace {

using Vec2d = Eigen::Vector2d;

Body single(std::string name, bool creased, Solid solid) {
    return {std::move(name), 1, creased,
            [solid](const Vec3d& p) { return solid(p).distance <= 0 ? 1 : 0; },
            [solid](const LabelPair&, const Vec3d& p) { return solid(p); }};
}

/// A polynomial of x^2, y^2, z^2: value <= 0 inside. The gradient is with respect to the squares.
struct Even {
    double (*value)(const Vec3d& squares);
    Vec3d (*gradient)(const Vec3d& squares);
    double reach;  ///< greatest distance of the surface from the origin
};

Body polynomial(std::string name, const Even& even) {
    const double scale = even.reach / 0.44;
    const Implicit surface{[=](const Vec3d& p) { return even.value((scale * p).cwiseAbs2()); },
                           [=](const Vec3d& p) -> Vec3d {
                               const Vec3d x = scale * p;
                               return 2 * scale * x.cwiseProduct(even.gradient(x.cwiseAbs2()));
                           }};
    Body body = single(std::move(name), false, implicit(surface));
    body.labelAt = [=](const Vec3d& p) { return surface.value(p) <= 0 ? 1 : 0; };
    return body;
}

/// 0.03 (x^4 + y^4 + z^4) - 2 (x^2 + y^2 + z^2) - 8
Even goursat() {
    return {[](const Vec3d& s) { return 0.03 * s.squaredNorm() - 2 * s.sum() - 8; },
            [](const Vec3d& s) -> Vec3d { return 0.06 * s - Vec3d::Constant(2); }, 14.28};
}

/// x^4 + y^4 + z^4 - 9^4
Even roundedCube() {
    return {[](const Vec3d& s) { return s.squaredNorm() - 6561; },
            [](const Vec3d& s) -> Vec3d { return 2 * s; }, 9 * std::pow(3, 0.25)};
}

/// x^2 y^2 z^2 + 4 x^2 + 4 y^2 + 3 z^2 - 100
Even leopold() {
    return {[](const Vec3d& s) { return s.prod() + 4 * s.x() + 4 * s.y() + 3 * s.z() - 100; },
            [](const Vec3d& s) {
                return Vec3d(s.y() * s.z() + 4, s.x() * s.z() + 4, s.x() * s.y() + 3);
            },
            std::sqrt(100 / 3.0)};
}

/// Planes, a hollow and a round side, creases of several angles that arcs run into, and one round
/// side that meets its neighbours smoothly.
Body fandisk() {
    constexpr double kScale = 0.44 / 5.6;
    const auto at = [](double x, double y) { return Vec2d(kScale * x, kScale * y); };
    std::vector<Side> profile = {
        {at(-4, -3), at(4, -3)}, {at(4, -3), at(4, -1)}, {at(4, -1), at(2, 1), true, at(4, 1)},
        {at(2, 1), at(1, 3)},    {at(1, 3), at(-2, 3)},  {at(-2, 3), at(-4, 1), true, at(-2, 1)},
        {at(-4, 1), at(-4, -3)}};
    std::vector<Vec2d> creases = {at(-4, -3), at(4, -3), at(4, -1), at(2, 1), at(1, 3)};
    return single("fandisk", true, extrusion(std::move(profile), 2.5 * kScale, creases));
}

Body sectors() {
    SectorFrame frame(0);
    frame.centre.setZero();
    constexpr double kRadius = 0.42;
    const Sectors exact{frame, kRadius};
    const auto labelAt = [=](const Vec3d& p) {
        return p.norm() > kRadius ? 0 : frame.labelOf(p, 3);
    };
    const auto foot = [=](const LabelPair& labels, const Vec3d& p) {
        const double distance = exact.distance(labels, p);
        const Vec3d normal = exact.normal(labels, p);
        return Foot{p - distance * normal, normal, distance, exact.edge(labels, p)};
    };
    return {"sectors", 3, true, labelAt, foot};
}

/// An interface of a body with several labels: whose surface it is on, and which surfaces end it.
struct Part {
    Solid solid;
    std::vector<Solid> rims;
};
using Parts = std::map<LabelPair, Part>;

LabelPair between(int inner, int outer) {
    return {static_cast<Label>(inner), static_cast<Label>(outer)};
}

/// For labels that meet only where noise has put them.
Foot nearestFoot(const Parts& parts, const Vec3d& p) {
    Foot nearest{.distance = kInfinite};
    for (const auto& [pair, part] : parts) {
        const Foot foot = part.solid(p);
        if (std::abs(foot.distance) < std::abs(nearest.distance)) nearest = foot;
    }
    return nearest;
}

Body composed(std::string name, int labels, bool creased, std::function<int(const Vec3d&)> labelAt,
              Parts parts) {
    const auto foot = [parts = std::move(parts)](const LabelPair& pair, const Vec3d& p) {
        const auto found = parts.find(pair);
        if (found == parts.end()) return nearestFoot(parts, p);
        const Part& part = found->second;
        Foot result = part.solid(p);
        for (const Solid& rim : part.rims)
            result.edge = std::min(result.edge, std::hypot(rim(p).distance, result.distance));
        return result;
    };
    return {std::move(name), labels, creased, std::move(labelAt), foot};
}

Body nestedBalls() {
    const Solid outer = ball(Vec3d::Zero(), 0.42);
    const Solid inner = ball(Vec3d(0.06, -0.04, 0.05), 0.24);
    const auto labelAt = [=](const Vec3d& p) {
        return inner(p).distance <= 0 ? 1 : outer(p).distance <= 0 ? 2 : 0;
    };
    return composed("nested", 2, false, labelAt,
                    {{between(1, 2), {inner, {}}}, {between(2, 0), {outer, {}}}});
}

/// The cells of eight points in a ball.
Body foam() {
    static const std::array<Vec3d, 8> seeds = {
        Vec3d(0.19, 0.16, 0.14),   Vec3d(-0.21, 0.13, 0.17), Vec3d(0.15, -0.22, 0.12),
        Vec3d(-0.14, -0.18, 0.19), Vec3d(0.22, 0.11, -0.18), Vec3d(-0.17, 0.2, -0.13),
        Vec3d(0.12, -0.16, -0.22), Vec3d(-0.2, -0.14, -0.16)};
    const Solid whole = ball(Vec3d::Zero(), 0.42);
    const auto labelAt = [=](const Vec3d& p) {
        if (whole(p).distance > 0) return 0;
        int nearest = 0;
        for (int i = 1; i < 8; ++i)
            if ((p - seeds[i]).squaredNorm() < (p - seeds[nearest]).squaredNorm()) nearest = i;
        return nearest + 1;
    };
    Parts parts;
    for (int a = 0; a < 8; ++a) {
        parts[between(a + 1, 0)] = {whole, {}};
        for (int b = a + 1; b < 8; ++b)
            parts[between(a + 1, b + 1)] = {
                halfSpace(0.5 * (seeds[a] + seeds[b]), (seeds[b] - seeds[a]).normalized()), {}};
    }
    return composed("foam", 8, false, labelAt, std::move(parts));
}

/// Height of the rock of `terrain` above its water level.
double height(double x, double y) {
    return 0.06 * std::sin(7 * x + 0.4) * std::cos(6 * y - 0.3) + 0.03 * std::sin(11 * x - 9 * y);
}

/// A block of hills with a lake: rock is label 1, water 2.
Body terrain() {
    const Implicit hills{[](const Vec3d& p) { return p.z() - height(p.x(), p.y()); },
                         [](const Vec3d& p) {
                             const double wave = 0.03 * std::cos(11 * p.x() - 9 * p.y());
                             const double a = 7 * p.x() + 0.4;
                             const double b = 6 * p.y() - 0.3;
                             return Vec3d(-0.42 * std::cos(a) * std::cos(b) - 11 * wave,
                                          0.36 * std::sin(a) * std::sin(b) + 9 * wave, 1);
                         }};
    const Solid ground = implicit(hills);
    const Solid block = box(Vec3d(-0.25, -0.25, -0.25), Vec3d(0.25, 0.25, 9));
    const Solid below = halfSpace(Vec3d(0, 0, 0.01), Vec3d::UnitZ());
    const auto labelAt = [=](const Vec3d& p) {
        if (block(p).distance > 0) return 0;
        return hills.value(p) <= 0 ? 1 : p.z() <= 0.01 ? 2 : 0;
    };
    return composed("terrain", 2, false, labelAt,
                    {{between(1, 0), {intersection(block, ground), {below}}},
                     {between(2, 0), {intersection(block, below), {ground}}},
                     {between(1, 2), {ground, {block, below}}}});
}

/// Walls (1), a pitched roof (2) and a chimney (3) that stands on it.
Body house() {
    constexpr double kFar = 2;  // where walls are continued to
    constexpr double kEaves = 0.04;
    const Solid walls = box(Vec3d(-0.26, -0.2, -0.26), Vec3d(0.26, 0.2, kFar));
    const Solid stack = box(Vec3d(0.08, 0.05, -kFar), Vec3d(0.17, 0.14, 0.26));
    const Solid floor = halfSpace(Vec3d(0, 0, kEaves), Vec3d::UnitZ());
    const Solid slope = halfSpace(Vec3d(0, 0, 0.24), Vec3d(0, 1, 1).normalized());
    const Vec2d apex(0, 0.24);
    const Vec2d left(-0.24 - kFar, -kFar);
    const Vec2d right(0.24 + kFar, -kFar);
    Mat3d along;  // the profile lies in the yz plane and is swept along x
    along << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    const Solid roof =
        turned(extrusion({{left, right}, {right, apex}, {apex, left}}, 0.26, {apex}), along);
    const auto labelAt = [=](const Vec3d& p) {
        if (walls(p).distance <= 0 && p.z() <= kEaves) return 1;
        if (p.z() > kEaves && roof(p).distance <= 0) return 2;
        return p.z() > kEaves && stack(p).distance <= 0 ? 3 : 0;
    };
    return composed("house", 3, true, labelAt,
                    {{between(1, 0), {walls, {floor}}},
                     {between(2, 0), {roof, {floor, stack}}},
                     {between(3, 0), {stack, {slope}}},
                     {between(1, 2), {floor, {walls}}},
                     {between(2, 3), {slope, {stack}}}});
}

std::vector<Body> makeBodies() {
    const Vec3d sides = Vec3d(13.2, 9.1, 7.4) * (0.44 / 17.7);  // as the sample `rotated_box`
    const Vec3d cube = Vec3d::Constant(0.352);
    return {
        single("sphere", false, ball(Vec3d::Zero(), 0.42)),
        single("torus", false, torus(0.33, 0.11)),
        polynomial("goursat", goursat()),
        polynomial("rounded cube", roundedCube()),
        polynomial("leopold", leopold()),
        single("capsule", false, capsule(0.22, 0.2)),
        single("box", true, box(-sides, sides)),
        single("cube and ball", true, intersection(box(-cube, cube), ball(Vec3d::Zero(), 0.44))),
        fandisk(),
        sectors(),
        nestedBalls(),
        foam(),
        terrain(),
        house()};
}

}  // namespace

const std::vector<Body>& bodies() {
    static const std::vector<Body> all = makeBodies();
    return all;
}

const Body& body(const std::string& name) {
    for (const Body& one : bodies())
        if (one.name == name) return one;
    std::abort();
}

Pose pose(std::uint32_t number) {
    std::mt19937 random(1000 + number);
    Pose result{randomRotation(random), Vec3d::Zero()};
    for (double& x : result.shift) x = unitDraw(random) - 0.5;
    return result;
}

Shape digitize(const Body& body, int resolution, const Pose& pose) {
    const double scale = resolution;
    const Vec3d center = Vec3d::Constant(0.5 * scale) + pose.shift;
    const auto local = [=](const Vec3d& p) -> Vec3d {
        return pose.rotation.transpose() * (p - center) / scale;
    };
    const auto foot = body.foot;
    Shape shape;
    shape.name = body.name;
    shape.grid = makeGrid(Vec3i::Constant(resolution), body.labels, [&](const Vec3i& v) {
        return body.labelAt(local(v.cast<double>() + Vec3d::Constant(0.5)));
    });
    shape.distance = [=](const LabelPair& l, const Vec3d& p) {
        return scale * foot(l, local(p)).distance;
    };
    shape.normal = [=](const LabelPair& l, const Vec3d& p) -> Vec3d {
        return pose.rotation * foot(l, local(p)).normal;
    };
    shape.edge = [=](const LabelPair& l, const Vec3d& p) { return scale * foot(l, local(p)).edge; };
    shape.measured = [](const LabelPair&, const Vec3d&) { return true; };
    return shape;
}

}  // namespace rivage::study
