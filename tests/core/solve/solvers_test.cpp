#include <doctest/doctest.h>

#include <vector>

#include "tests/core/solve/prepared.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

const EnergyOptions kPaper = presetOptions(Preset::paper).energy;

/// H assembled, and the box of each coordinate of the displacement.
struct Dense {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd right;
    Eigen::VectorXd limit;

    Dense(const Energy& energy, double displacementLimit) {
        const DigitalSurface& surface = energy.surface();
        const auto size = static_cast<Eigen::Index>(3 * energy.size());
        matrix = Eigen::MatrixXd::Zero(size, size);
        energy.forEachSquare([&](std::span<const Energy::Coefficient> row, const Mat3d& block) {
            for (const auto& i : row)
                for (const auto& j : row)
                    matrix.block<3, 3>(3 * index(i.pointel), 3 * index(j.pointel)) +=
                        i.value * j.value * block;
        });
        right.resize(size);
        limit.resize(size);
        const PointelVectors gradient = energy.gradient(energy.restPositions());
        for (std::uint32_t i = 0; i < energy.size(); ++i)
            for (int k = 0; k < 3; ++k) {
                const PointelId p{i};
                const bool fixed =
                    !surface.fixedAxes.empty() && (surface.fixedAxes[p] >> k & 1) != 0;
                right[3 * i + k] = -gradient[p][k] / 2;
                limit[3 * i + k] = fixed ? 0 : displacementLimit * surface.spacing[k];
            }
    }

    /// Projected Gauss-Seidel: each coordinate in turn goes to its best place in its interval,
    /// until none moves.
    [[nodiscard]] PointelVectors minimizer(const Energy& energy) const {
        Eigen::VectorXd d = Eigen::VectorXd::Zero(right.size());
        double moved = 1;
        for (int sweep = 0; sweep < 100000 && moved > 1e-12; ++sweep) {
            moved = 0;
            for (Eigen::Index c = 0; c < d.size(); ++c) {
                const double best = d[c] + (right[c] - matrix.col(c).dot(d)) / matrix(c, c);
                const double next = std::clamp(best, -limit[c], limit[c]);
                moved = std::max(moved, std::abs(next - d[c]));
                d[c] = next;
            }
        }
        REQUIRE(moved <= 1e-12);
        PointelVectors x = energy.restPositions();
        for (std::uint32_t i = 0; i < energy.size(); ++i) x[PointelId{i}] += d.segment<3>(3 * i);
        return x;
    }
};

/// Holds the pointels on the low x side in their face, and makes voxels twice as high.
void openLowX(DigitalSurface& surface) {
    surface.spacing = Vec3d(1, 1, 2);
    surface.fixedAxes.resize(surface.pointelCount(), 0);
    for (std::uint32_t i = 0; i < surface.pointelCount(); ++i) {
        const PointelId p{i};
        if (surface.pointels[p].x() == 0) surface.fixedAxes[p] |= 1;
        if (surface.pointels[p].z() == 0) surface.fixedAxes[p] |= 4;
    }
}

VoxelGrid cornerBall() {
    return makeGrid({6, 6, 5}, 2, [](const Vec3i& v) {
        const double r = (v.cast<double>() + Vec3d(0.5, -2.5, 0.7)).norm();
        return r > 5.2 ? 0 : v.y() > 2 ? 2 : 1;
    });
}

}  // namespace

TEST_SUITE("core/solve") {
    TEST_CASE("differential: the box problem against projected Gauss-Seidel on a dense matrix") {
        const auto untouched = [](DigitalSurface&) {};
        for (const bool open : {false, true})
            for (const auto& grid : {cornerBall(), randomGrid(9, {3, 3, 3}, 3)})
                for (const EnergyOptions& options : {EnergyOptions{}, kPaper})
                    for (const double limit : {0.1, 0.49}) {
                        const PreparedSurface prepared =
                            open ? PreparedSurface(grid, options, openLowX)
                                 : PreparedSurface(grid, options, untouched);
                        const Energy energy = prepared.energy();
                        const PointelVectors expected = Dense(energy, limit).minimizer(energy);
                        const auto solution =
                            minimize(energy, {.displacementLimit = limit, .tolerance = 1e-6}, {});
                        REQUIRE(solution);
                        CHECK(solution->converged);
                        CHECK(solution->residual <= 1e-6);
                        const double best = energy.value(expected).total();
                        const double found = energy.value(solution->positions).total();
                        CHECK(found == doctest::Approx(best).epsilon(1e-6));
                        CHECK(largestDifference(solution->positions, expected) < 1e-3);
                    }
    }

    TEST_CASE("fixed coordinates: held by every solver, with and without a limit") {
        const PreparedSurface prepared(cornerBall(), {}, openLowX);
        const Energy energy = prepared.energy();
        for (const std::optional<double> limit : {std::optional<double>(), std::optional(0.2)}) {
            const PointelVectors expected = Dense(energy, limit.value_or(1e9)).minimizer(energy);
            for (const SolverKind solver :
                 {SolverKind::pcg, SolverKind::multigrid, SolverKind::cholesky,
                  SolverKind::projected, SolverKind::accelerated, SolverKind::gradientDescent}) {
                const bool linear = solver == SolverKind::pcg || solver == SolverKind::multigrid ||
                                    solver == SolverKind::cholesky;
                if (linear && limit) continue;
                CAPTURE(static_cast<int>(solver));
                const auto solution = minimize(energy,
                                               {.solver = solver,
                                                .displacementLimit = limit,
                                                .tolerance = 1e-7,
                                                .maxIterations = 20000},
                                               {});
                REQUIRE(solution);
                CHECK(largestDifference(solution->positions, expected) < 1e-4);
                for (std::uint32_t i = 0; i < energy.size(); ++i)
                    for (int k = 0; k < 3; ++k) {
                        const PointelId p{i};
                        const double rest = prepared.surface.position(p)[k];
                        const double d = std::abs(solution->positions[p][k] - rest);
                        if (prepared.surface.fixedAxes[p] >> k & 1) CHECK(d == 0);
                        if (limit) CHECK(d <= *limit * prepared.surface.spacing[k] + 1e-12);
                    }
            }
        }
    }

    TEST_CASE("accelerated: as many steps as asked for, in the box, and good after fifty") {
        const PreparedSurface prepared(sectorGrid(24, 10.5), {}, [](DigitalSurface&) {});
        const Energy energy = prepared.energy();
        const auto exact = minimize(energy, {.tolerance = 1e-9}, {});
        REQUIRE(exact);
        double last = energy.value(energy.restPositions()).total();
        const double best = energy.value(exact->positions).total();
        for (const int steps : {5, 10, 50}) {
            const auto solution =
                minimize(energy, {.solver = SolverKind::accelerated, .maxIterations = steps}, {});
            REQUIRE(solution);
            CHECK(solution->iterations == steps);
            CHECK(largestDifference(solution->positions, energy.restPositions()) <= 0.49 + 1e-12);
            const double now = energy.value(solution->positions).total();
            CHECK(now < last);
            last = now;
        }
        CHECK(last < 1.05 * best);
        const auto early = minimize(
            energy, {.solver = SolverKind::accelerated, .tolerance = 0.05, .maxIterations = 500},
            {});
        REQUIRE(early);
        CHECK(early->converged);
        CHECK(early->iterations < 500);
    }

    TEST_CASE("warm start: a solution is recognized by every iterative solver") {
        const PreparedSurface prepared(sectorGrid(16, 6.5), {}, [](DigitalSurface&) {});
        const Energy energy = prepared.energy();
        for (const std::optional<double> limit : {std::optional<double>(), std::optional(0.2)}) {
            const auto exact =
                minimize(energy, {.displacementLimit = limit, .tolerance = 1e-9}, {});
            REQUIRE(exact);
            for (const SolverKind solver :
                 {SolverKind::pcg, SolverKind::multigrid, SolverKind::projected,
                  SolverKind::accelerated, SolverKind::gradientDescent}) {
                CAPTURE(static_cast<int>(solver));
                if (limit && (solver == SolverKind::pcg || solver == SolverKind::multigrid))
                    continue;
                const auto again = minimize(energy, {.solver = solver, .displacementLimit = limit},
                                            {}, {.positions = &exact->positions});
                REQUIRE(again);
                CHECK(again->converged);
                CHECK(again->iterations == 0);
                CHECK(largestDifference(again->positions, exact->positions) < 1e-10);
            }
        }
    }

    TEST_CASE("determinism: multigrid and accelerated give the same bits for threads 1, 2, 7") {
        const PreparedSurface prepared(sectorGrid(40, 17), {}, [](DigitalSurface&) {});
        for (const SolverKind solver : {SolverKind::multigrid, SolverKind::accelerated}) {
            PointelVectors expected;
            for (const int threads : {1, 2, 7}) {
                const Energy energy = prepared.energy(threads);
                const auto solution = minimize(
                    energy,
                    {.solver = solver, .displacementLimit = std::nullopt, .maxIterations = 60},
                    {.threads = threads});
                REQUIRE(solution);
                if (threads == 1) expected = solution->positions;
                CHECK(solution->positions == expected);
            }
        }
    }

    TEST_CASE("stops: every solver gives up at whichever poll asks it to") {
        const PreparedSurface prepared(sectorGrid(14, 5.5), {}, [](DigitalSurface&) {});
        const Energy energy = prepared.energy();
        for (const SolverKind solver :
             {SolverKind::pcg, SolverKind::multigrid, SolverKind::cholesky, SolverKind::projected,
              SolverKind::accelerated, SolverKind::gradientDescent})
            for (int stopAt = 1; stopAt <= 12; ++stopAt) {
                int polls = 0;
                const RunContext run{.stopRequested = [&] { return ++polls >= stopAt; }};
                const auto solution = minimize(
                    energy,
                    {.solver = solver, .displacementLimit = std::nullopt, .tolerance = 1e-13}, run);
                CAPTURE(static_cast<int>(solver));
                if (solution) {
                    CHECK(polls < stopAt);  // it was done before
                    continue;
                }
                CHECK(solution.error().code == ErrorCode::cancelled);
                CHECK(polls <= stopAt + 12);  // it does not go on with long loops
            }
    }
}
