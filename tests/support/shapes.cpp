#include "tests/support/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "core/samples/samples.h"
#include "tests/support/balls.h"
#include "tests/support/random.h"
#include "tests/support/solids.h"

namespace rivage::test {

namespace {

double noEdge(const LabelPair&, const Vec3d&) { return kInfinite; }
bool everywhere(const LabelPair&, const Vec3d&) { return true; }

/// One label where a voxel's centre is inside.
template <typename Distance>
VoxelGrid solidGrid(const Vec3i& size, const Distance& distance) {
    return makeGrid(size, 1, [&](const Vec3i& v) {
        return distance(v.cast<double>() + Vec3d::Constant(0.5)) <= 0 ? 1 : 0;
    });
}

/// A shape of one label from functions of the point alone.
template <typename Distance, typename Normal, typename Edge>
Shape solid(std::string name, const Vec3i& size, Distance distance, Normal normal, Edge edge) {
    return {std::move(name),
            solidGrid(size, distance),
            [=](const LabelPair&, const Vec3d& p) { return distance(p); },
            [=](const LabelPair&, const Vec3d& p) -> Vec3d { return normal(p); },
            [=](const LabelPair&, const Vec3d& p) { return edge(p); },
            everywhere};
}

Shape boxShape(std::string name, const Vec3i& size, const Box& box) {
    return solid(
        std::move(name), size, [=](const Vec3d& p) { return box.distance(p); },
        [=](const Vec3d& p) { return box.normal(p); }, [=](const Vec3d& p) { return box.edge(p); });
}

struct CappedBall {
    Vec3d center{17.1, 16.9, 17.2};
    Vec3d axis = Vec3d(0.4, 0.3, 0.8).normalized();
    double radius = 14;
    double height = 5;  // of the plane over the centre

    [[nodiscard]] double overPlane(const Vec3d& p) const { return axis.dot(p - center) - height; }
    [[nodiscard]] double overSphere(const Vec3d& p) const { return (p - center).norm() - radius; }
    [[nodiscard]] double distance(const Vec3d& p) const {
        return std::max(overPlane(p), overSphere(p));
    }
    [[nodiscard]] Vec3d normal(const Vec3d& p) const {
        return overPlane(p) > overSphere(p) ? axis : (p - center).normalized();
    }
    [[nodiscard]] double edge(const Vec3d& p) const {
        const double fromAxis = axis.cross(p - center).norm();
        return std::hypot(overPlane(p), fromAxis - std::sqrt(radius * radius - height * height));
    }
};

struct Balls {
    std::array<Vec3d, 3> centers;
    std::array<double, 3> radii;

    explicit Balls(int side)  // the balls of `ballsGrid`, in voxels
        : centers{Vec3d(0.361, 0.402, 0.423) * side, Vec3d(0.643, 0.437, 0.458) * side,
                  Vec3d(0.497, 0.662, 0.583) * side},
          radii{0.262 * side, 0.241 * side, 0.253 * side} {}
    [[nodiscard]] double distance(std::size_t ball, const Vec3d& p) const {
        return (p - centers[ball]).norm() - radii[ball];
    }
    [[nodiscard]] bool measured(const LabelPair& labels, const Vec3d& p) const {
        constexpr double kFromOthers = 3;  // voxels
        if (labels.outer != kBackground) return false;
        for (std::size_t other = 0; other < 3; ++other)
            if (other != index(labels.inner) - 1U && distance(other, p) < kFromOthers) return false;
        return true;
    }
};

}  // namespace

Shape sphereShape() {
    const SampleSphere sphere;
    return solid(
        "sphere", sphere.size, [=](const Vec3d& p) { return signedDistance(sphere, p); },
        [=](const Vec3d& p) { return (p - sphere.center).normalized(); },
        [](const Vec3d&) { return kInfinite; });
}

Shape sectorsShape() {
    constexpr int kSide = 38;
    constexpr double kRadius = 16;
    const Sectors sectors{SectorFrame(kSide), kRadius};
    return {"sectors",
            sectorGrid(kSide, kRadius, 3),
            [=](const LabelPair& l, const Vec3d& p) { return sectors.distance(l, p); },
            [=](const LabelPair& l, const Vec3d& p) { return sectors.normal(l, p); },
            [=](const LabelPair& l, const Vec3d& p) { return sectors.edge(l, p); },
            everywhere};
}

Shape sampleBoxShape() {
    const SampleBox box;
    return boxShape("sample box", box.size, {box.center, box.halfSides, box.axes()});
}

Shape randomBoxShape(std::uint32_t seed) {
    std::mt19937 random(seed);
    const Mat3d axes = randomRotation(random);
    Vec3d center;
    for (double& x : center) x = 20 + static_cast<double>(random()) / 4294967296.0;
    return boxShape("random box " + std::to_string(seed), Vec3i::Constant(41),
                    {center, SampleBox().halfSides, axes});
}

Shape cappedBallShape() {
    const CappedBall ball;
    return solid(
        "capped ball", Vec3i::Constant(34), [=](const Vec3d& p) { return ball.distance(p); },
        [=](const Vec3d& p) { return ball.normal(p); },
        [=](const Vec3d& p) { return ball.edge(p); });
}

Shape torusShape() {
    const SampleTorus torus;
    return solid(
        "torus", torus.size, [=](const Vec3d& p) { return signedDistance(torus, p); },
        [=](const Vec3d& p) -> Vec3d {
            Vec3d core = p - torus.center;
            core.z() = 0;
            core *= torus.majorRadius / core.norm();
            return (p - torus.center - core).normalized();
        },
        [](const Vec3d&) { return kInfinite; });
}

Shape cubeShape(int side) {
    const Vec3d half = Vec3d::Constant(side / 2.0);
    return boxShape("cube " + std::to_string(side), Vec3i::Constant(side),
                    {half, half, Mat3d::Identity()});
}

Shape ballsShape(int side) {
    const Balls balls(side);
    const auto ball = [](const LabelPair& labels) { return index(labels.inner) - std::size_t{1}; };
    return {"balls " + std::to_string(side),
            ballsGrid(side),
            [=](const LabelPair& l, const Vec3d& p) { return balls.distance(ball(l), p); },
            [=](const LabelPair& l, const Vec3d& p) -> Vec3d {
                return (p - balls.centers[ball(l)]).normalized();
            },
            noEdge,
            [=](const LabelPair& l, const Vec3d& p) { return balls.measured(l, p); }};
}

Shape withLabelNoise(Shape shape, double p, std::uint32_t seed) {
    shape.grid = withLabelNoise(shape.grid, p, seed);
    return shape;
}

}  // namespace rivage::test
