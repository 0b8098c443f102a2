#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "tests/support/grids.h"
#include "tests/support/intersections.h"
#include "tests/support/regularized.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

constexpr int kSide = 20;
constexpr double kMargin = 4;  // from the border, where faces lack neighbours

/// A naive digital plane: the thinnest wall with this normal that no path from face to
/// face of voxels crosses, |n|_inf thick in the units of n.
VoxelGrid wallGrid(const Vec3i& normal) {
    const int middle = (kSide / 2) * normal.sum();
    VoxelGrid grid = makeGrid(Vec3i::Constant(kSide), 1, [&](const Vec3i& v) {
        const int height = v.dot(normal) - middle;
        return height >= 0 && height < normal.maxCoeff() ? 1 : 0;
    });
    grid.openBorder = true;  // a wall without a rim
    return grid;
}

/// What there is to say about the two sides of a wall, away from its rim.
struct Sides {
    double thickness = 0;    ///< distance of the mean heights of the two sides along the normal
    double roughness = 0;    ///< rms of the heights about their means
    double normalError = 0;  ///< degrees, mean over the faces
};

class SideStatistics {
public:
    void add(double height, double error) {
        ++count_;
        sum_ += height;
        squares_ += height * height;
        errors_ += error;
    }
    [[nodiscard]] double mean() const { return sum_ / count_; }
    [[nodiscard]] double variance() const { return squares_ / count_ - mean() * mean(); }
    [[nodiscard]] double error() const { return errors_ / count_; }

private:
    double count_ = 0;
    double sum_ = 0;
    double squares_ = 0;
    double errors_ = 0;
};

Sides measure(const Regularized& result, const Vec3d& normal) {
    std::array<SideStatistics, 2> sides;
    for (std::uint32_t i = 0; i < result.surface.surfelCount(); ++i) {
        const SurfelId s{i};
        const Vec3d rest = result.surface.centre(s);
        if (rest.minCoeff() < kMargin || rest.maxCoeff() > kSide - kMargin) continue;
        const auto& c = result.surface.corners[s];
        const auto& x = result.positions;
        const Vec3d across = (x[c[2]] - x[c[0]]).cross(x[c[3]] - x[c[1]]).normalized();
        const double turn = result.surface.trivialNormal(s).cast<double>().dot(normal);
        const double cosine = std::min(1.0, across.dot(turn > 0 ? normal : Vec3d(-normal)));
        const double height = 0.25 * (x[c[0]] + x[c[1]] + x[c[2]] + x[c[3]]).dot(normal);
        sides[turn > 0 ? 1 : 0].add(height, std::acos(cosine) * 180 / M_PI);
    }
    return {sides[1].mean() - sides[0].mean(),
            std::sqrt(0.5 * (sides[0].variance() + sides[1].variance())),
            0.5 * (sides[0].error() + sides[1].error())};
}

Sides regularizedWall(const Vec3i& direction, bool split) {
    const Vec3d normal = direction.cast<double>().normalized();
    Regularized wall{*extractSurface(wallGrid(direction), {}), {}};
    const SurfelLinks links = *linkSurfels(wall.surface, {});
    // The border is to be free here, so that what it holds back does not reach into the middle.
    wall.surface.fixedAxes = {};
    if (split) CHECK(*splitUmbrellas(wall.surface, links, {}) > 100);
    const MethodOptions options;
    const Energy energy(wall.surface, NormalField(wall.surface.surfelCount(), normal),
                        EnergyWeights::uniform(wall.surface, options.energy), options.energy, 1);
    wall.positions = minimize(energy, {.tolerance = 1e-5}, {})->positions;
    const Tangles tangles = untangle(wall.surface, wall.positions, {});
    CHECK(tangles.crossing == 0);
    CHECK(countIntersections(wall.surface, wall.positions) == 0);
    return measure(wall, normal);
}

}  // namespace

TEST_SUITE("core/pipeline") {
    TEST_CASE("split: a diagonal wall one voxel thick keeps its thickness and its normal") {
        for (const Vec3i& normal : {Vec3i(1, 1, 0), Vec3i(1, 1, 1), Vec3i(2, 1, 0), Vec3i(1, 2, 3),
                                    Vec3i(3, 3, 1), Vec3i(3, 2, 2)}) {
            const std::string name = std::to_string(normal.x()) + " " + std::to_string(normal.y()) +
                                     " " + std::to_string(normal.z());
            CAPTURE(name);
            // The volume of the voxels over the area of the plane.
            const double ideal = normal.maxCoeff() / normal.cast<double>().norm();
            const Sides with = regularizedWall(normal, true);
            const Sides without = regularizedWall(normal, false);
            CHECK(std::abs(with.thickness - ideal) < 0.02 * ideal);
            CHECK(with.roughness < 0.01);
            CHECK(with.normalError < 0.5);
            CHECK(without.thickness < 0.3 * ideal);
        }
    }
}
