#include <doctest/doctest.h>

#include <random>

#include "core/energy/energy.h"
#include "tests/support/grids.h"

using namespace rivage::test;

namespace {

PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }

/// A multi-label surface with a rest shape and normals at random.
struct Problem {
    DigitalSurface surface;
    RestShape rest;
    NormalField normals;

    explicit Problem(std::uint32_t seed)
        : surface(*extractSurface(randomGrid(seed, {3, 4, 3}, 3), {})) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> uniform(-0.5, 0.5);
        const auto vector = [&] {
            return Vec3d(uniform(random), uniform(random), uniform(random));
        };
        for (std::size_t i = 0; i < surface.pointelCount(); ++i) {
            rest.positions.push_back(surface.position(pointel(i)) + vector());
            rest.targets.push_back(rest.positions.raw().back() + vector());
        }
        for (std::size_t f = 0; f < surface.surfelCount(); ++f) {
            rest.normals.push_back(vector().normalized());
            normals.push_back(vector().normalized());
        }
    }
    [[nodiscard]] Energy energy(const EnergyOptions& options, const NormalField& with) const {
        return {surface, with, EnergyWeights::uniform(surface, options), options, 1, rest};
    }
};

}  // namespace

TEST_SUITE_BEGIN("core/energy");

TEST_CASE("RestShape: with its own normals it has no energy and pulls nowhere") {
    Problem problem(3);
    problem.rest.targets = problem.rest.positions;
    const Energy energy = problem.energy({}, problem.rest.normals);
    CHECK(energy.restPositions() == problem.rest.positions);
    CHECK(energy.value(problem.rest.positions).total() == 0);
    for (const Vec3d& force : energy.restForce()) CHECK(force == Vec3d(0, 0, 0));
}

TEST_CASE("RestShape: the gradient is that of finite differences, at rest and elsewhere") {
    constexpr double kStep = 1e-5;
    for (const Fairness fairness : {Fairness::umbrella, Fairness::tangential}) {
        const Problem problem(5);
        const EnergyOptions options{.alpha = 0.3, .gamma = 0.7, .fairness = fairness};
        const Energy energy = problem.energy(options, problem.normals);
        PointelVectors elsewhere = problem.rest.positions;
        for (std::size_t i = 0; i < elsewhere.size(); ++i)
            elsewhere[pointel(i)] += 0.1 * problem.normals.raw()[i % problem.normals.size()];
        for (PointelVectors x : {problem.rest.positions, elsewhere}) {
            const PointelVectors gradient = energy.gradient(x);
            for (std::size_t i = 0; i < x.size(); i += 7)
                for (int k = 0; k < 3; ++k) {
                    double& moved = x[pointel(i)][k];
                    const double here = moved;
                    moved = here + kStep;
                    const double above = energy.value(x).total();
                    moved = here - kStep;
                    const double below = energy.value(x).total();
                    moved = here;
                    CHECK(gradient[pointel(i)][k] ==
                          doctest::Approx((above - below) / (2 * kStep)).epsilon(1e-6));
                }
        }
        const PointelVectors force = energy.restForce();
        const PointelVectors atRest = energy.gradient(problem.rest.positions);
        for (std::size_t i = 0; i < force.size(); ++i)
            CHECK((2 * force[pointel(i)] + atRest[pointel(i)]).isZero(1e-12));
    }
}

TEST_SUITE_END();
