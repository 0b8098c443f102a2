#include <doctest/doctest.h>

#include <algorithm>

#include "core/normals/normal_field.h"
#include "core/solve/minimize.h"
#include "tests/support/grids.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }

/// Everything before the solver, with the default options unless said otherwise.
struct Prepared {
    VoxelGrid grid;
    DigitalSurface surface;
    Energy energy;

    explicit Prepared(VoxelGrid g, const EnergyOptions& options = {}, int threads = 1,
                      const NormalOptions& normals = {})
        : grid(std::move(g)),
          surface(*extractSurface(grid, {})),
          energy(surface, *estimateNormals(grid, surface, *linkSurfels(surface, {}), normals, {}),
                 EnergyWeights::uniform(surface, options), options, threads) {}
    Prepared(const Prepared&) = delete;
};

const EnergyOptions kPaper = presetOptions(Preset::paper).energy;

SolveOptions freely(SolverKind solver, double tolerance = 1e-10) {
    return {.solver = solver,
            .displacementLimit = std::nullopt,
            .tolerance = tolerance,
            .maxIterations = 200000};
}

double maxDifference(const PointelVectors& a, const PointelVectors& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, (a[pointel(i)] - b[pointel(i)]).cwiseAbs().maxCoeff());
    return largest;
}

/// The KKT conditions of the box problem, component by component.
double kktViolation(const Energy& energy, const PointelVectors& x, double limit) {
    const PointelVectors gradient = energy.gradient(x);
    const PointelVectors rest = energy.restPositions();
    double worst = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const double d = x[pointel(i)][k] - rest[pointel(i)][k];
            const double g = gradient[pointel(i)][k];
            CHECK(std::abs(d) <= limit + 1e-12);  // p + d rounds
            const bool atLow = d <= -limit * (1 - 1e-12);
            const bool atHigh = d >= limit * (1 - 1e-12);
            const double violation = atLow    ? std::max(0.0, -g)
                                     : atHigh ? std::max(0.0, g)
                                              : std::abs(g);
            worst = std::max(worst, violation);
        }
    return worst;
}

}  // namespace

TEST_SUITE("core/solve") {
    TEST_CASE("differential: PCG against Cholesky below 1e-6 voxel") {
        for (const auto& [name, grid] : {std::pair{"sectors", sectorGrid(16, 6.5)},
                                         std::pair{"random", randomGrid(4, {5, 5, 5}, 3)}})
            for (const EnergyOptions& options : {kPaper, EnergyOptions{}}) {
                CAPTURE(name);
                const Prepared problem(grid, options);
                const auto fast = minimize(problem.energy, freely(SolverKind::pcg), {});
                const auto exact = minimize(problem.energy, freely(SolverKind::cholesky), {});
                REQUIRE(fast);
                REQUIRE(exact);
                CHECK(fast->converged);
                CHECK(exact->residual < 1e-12);
                CHECK(maxDifference(fast->positions, exact->positions) < 1e-6);
            }
    }

    TEST_CASE("differential: gradient descent reaches the minimizer of PCG") {
        const Prepared problem(sectorGrid(12, 4.5), {.alpha = 0.05});
        const auto slow = minimize(problem.energy, freely(SolverKind::gradientDescent), {});
        const auto fast = minimize(problem.energy, freely(SolverKind::pcg), {});
        REQUIRE(slow);
        REQUIRE(fast);
        CHECK(slow->converged);
        CHECK(maxDifference(slow->positions, fast->positions) < 1e-6);
    }

    TEST_CASE("property: gradient descent never increases the energy") {
        const Prepared problem(randomGrid(8, {6, 6, 6}, 4), kPaper);
        for (const std::optional<double> limit : {std::optional<double>(), std::optional(0.3)}) {
            double last = problem.energy.value(problem.energy.restPositions()).total();
            for (int steps = 1; steps <= 20; ++steps) {
                const auto solution = minimize(problem.energy,
                                               {.solver = SolverKind::gradientDescent,
                                                .displacementLimit = limit,
                                                .tolerance = 1e-12,
                                                .maxIterations = steps},
                                               {});
                REQUIRE(solution);
                CHECK(solution->iterations == steps);
                const double now = problem.energy.value(solution->positions).total();
                CHECK(now <= last);
                last = now;
            }
        }
    }

    TEST_CASE("property: the centroid is preserved with equal weights and no limit") {
        const Prepared problem(sectorGrid(16, 6.5), kPaper);
        const auto solution = minimize(problem.energy, freely(SolverKind::pcg, 1e-12), {});
        REQUIRE(solution);
        Vec3d shift = Vec3d::Zero();
        const PointelVectors rest = problem.energy.restPositions();
        for (std::size_t i = 0; i < rest.size(); ++i)
            shift += solution->positions[pointel(i)] - rest[pointel(i)];
        CHECK(shift.norm() / static_cast<double>(rest.size()) < 1e-9);
    }

    TEST_CASE("box: KKT conditions hold, also on every non-manifold configuration") {
        for (const auto& [name, grid] :
             {std::pair{"sectors", sectorGrid(20, 8.5)},
              std::pair{"random", randomGrid(6, {6, 6, 6}, 3)},
              std::pair{"checkerboard",
                        makeGrid({5, 5, 5}, 1, [](const Vec3i& v) { return v.sum() % 2; })}})
            for (const EnergyOptions& options : {kPaper, EnergyOptions{}})
                for (const double limit : {0.1, 0.49, 1.5}) {
                    CAPTURE(name);
                    CAPTURE(limit);
                    const Prepared problem(grid, options);
                    const auto solution = minimize(
                        problem.energy,
                        {.displacementLimit = limit, .tolerance = 1e-9, .maxIterations = 100000},
                        {});
                    REQUIRE(solution);
                    CHECK(solution->converged);
                    CHECK(kktViolation(problem.energy, solution->positions, limit) < 1e-6);
                }
    }

    TEST_CASE("differential: the box problem against projected gradient descent") {
        const Prepared problem(sectorGrid(12, 4.5), {.alpha = 0.02});
        const SolveOptions options{
            .displacementLimit = 0.2, .tolerance = 1e-10, .maxIterations = 200000};
        SolveOptions reference = options;
        reference.solver = SolverKind::gradientDescent;
        const auto fast = minimize(problem.energy, options, {});
        const auto slow = minimize(problem.energy, reference, {});
        REQUIRE(fast);
        REQUIRE(slow);
        CHECK(slow->converged);
        CHECK(maxDifference(fast->positions, slow->positions) < 1e-6);
        CHECK(fast->iterations < slow->iterations);
    }

    TEST_CASE("box: rooms off centre, to the KKT conditions, in place of the limit") {
        const Prepared ball(ballGrid(12, 5));
        IdVector<PointelId, Room> rooms;
        for (std::size_t i = 0; i < ball.energy.size(); ++i) {
            const double wide = 0.02 * static_cast<double>(i % 7);  // some may not move at all
            rooms.push_back({Vec3d(-wide, -2 * wide, -0.01), Vec3d(0.5 * wide, wide, 0)});
        }
        const auto solution =
            minimize(ball.energy, {.tolerance = 1e-9}, {}, {.rooms = &rooms}).value();
        CHECK(solution.converged);
        const PointelVectors gradient = ball.energy.gradient(solution.positions);
        double worst = 0;
        std::size_t atSides = 0;
        for (std::size_t i = 0; i < rooms.size(); ++i) {
            const Room& room = rooms[pointel(i)];
            const Vec3d d = solution.positions[pointel(i)] - ball.surface.position(pointel(i));
            for (int k = 0; k < 3; ++k) {
                CHECK(d[k] >= room.low[k] - 1e-12);
                CHECK(d[k] <= room.high[k] + 1e-12);
                const bool low = d[k] <= room.low[k] + 1e-12;
                const bool high = d[k] >= room.high[k] - 1e-12;
                atSides += low || high;
                const double g = gradient[pointel(i)][k];
                worst = std::max(worst, low && high ? 0.0 : low ? -g : high ? g : std::abs(g));
            }
        }
        CHECK(worst < 1e-6);
        CHECK(atSides > rooms.size());
        const auto refused =
            minimize(ball.energy, {.solver = SolverKind::pcg}, {}, {.rooms = &rooms});
        REQUIRE_FALSE(refused);
        CHECK(refused.error().code == ErrorCode::invalidOption);
    }

    TEST_CASE("box: clipping the free minimizer is not the answer") {
        const Prepared problem(sectorGrid(20, 8.5), kPaper);
        const double limit = 0.2;
        const auto box = minimize(problem.energy, {.displacementLimit = limit}, {});
        const auto free = minimize(problem.energy, freely(SolverKind::pcg), {});
        REQUIRE(box);
        REQUIRE(free);
        PointelVectors clipped = free->positions;
        const PointelVectors rest = problem.energy.restPositions();
        for (std::size_t i = 0; i < rest.size(); ++i) {
            const PointelId p = pointel(i);
            clipped[p] = rest[p] + (clipped[p] - rest[p]).cwiseMin(limit).cwiseMax(-limit);
        }
        CHECK(problem.energy.value(box->positions).total() < problem.energy.value(clipped).total());
    }

    TEST_CASE("box: a limit that nothing reaches gives the free minimizer") {
        const Prepared problem(ballGrid(14, 5.3), {.alpha = 0.05});
        const auto box =
            minimize(problem.energy, {.displacementLimit = 50.0, .tolerance = 1e-10}, {});
        const auto free = minimize(problem.energy, freely(SolverKind::pcg), {});
        REQUIRE(box);
        REQUIRE(free);
        CHECK(maxDifference(box->positions, free->positions) < 1e-7);
    }

    TEST_CASE("property: equivariant under the 48 symmetries of the cube") {
        // Off-centre and without symmetries of its own.
        const VoxelGrid grid = sectorGrid(13, 4.6);
        const Prepared base(grid);
        const auto expected = minimize(base.energy, {.tolerance = 1e-10}, {});
        REQUIRE(expected);
        for (const Symmetry& symmetry : cubeSymmetries()) {
            const Prepared moved(transformed(grid, symmetry));
            const auto solution = minimize(moved.energy, {.tolerance = 1e-10}, {});
            REQUIRE(solution);
            REQUIRE(moved.surface.pointelCount() == base.surface.pointelCount());
            std::vector<std::array<double, 6>> images;
            std::vector<std::array<double, 6>> found;
            const auto row = [](const Vec3d& p, const Vec3d& x) {
                return std::array{p[0], p[1], p[2], x[0], x[1], x[2]};
            };
            for (std::size_t i = 0; i < base.surface.pointelCount(); ++i) {
                const Vec3d p = base.surface.pointels[pointel(i)].cast<double>();
                images.push_back(
                    row(symmetry.point(p, grid.voxels.size()),
                        symmetry.point(expected->positions[pointel(i)], grid.voxels.size())));
                found.push_back(row(moved.surface.pointels[pointel(i)].cast<double>(),
                                    solution->positions[pointel(i)]));
            }
            std::sort(images.begin(), images.end());
            std::sort(found.begin(), found.end());
            double worst = 0;
            for (std::size_t i = 0; i < images.size(); ++i)
                for (std::size_t k = 0; k < 6; ++k)
                    worst = std::max(worst, std::abs(images[i][k] - found[i][k]));
            CHECK(worst < 1e-6);
        }
    }

    TEST_CASE("property: renaming the labels changes nothing") {
        const VoxelGrid grid = sectorGrid(16, 6.5);
        VoxelGrid renamed = grid;
        const MaterialId names[] = {MaterialId{0}, MaterialId{3}, MaterialId{1}, MaterialId{2}};
        renamed.voxels.remap(names);
        const Prepared a(grid);
        const Prepared b(renamed);
        const auto first = minimize(a.energy, {.tolerance = 1e-10}, {});
        const auto second = minimize(b.energy, {.tolerance = 1e-10}, {});
        REQUIRE(first);
        REQUIRE(second);
        CHECK(maxDifference(first->positions, second->positions) < 1e-7);
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same bits") {
        for (const SolveOptions& options :
             {SolveOptions{}, freely(SolverKind::pcg, 1e-6),
              SolveOptions{.solver = SolverKind::gradientDescent, .maxIterations = 30}}) {
            PointelVectors expected;
            for (const int threads : {1, 2, 7}) {
                const Prepared problem(sectorGrid(40, 17), {}, threads);
                const auto solution = minimize(problem.energy, options, {.threads = threads});
                REQUIRE(solution);
                if (threads == 1) expected = solution->positions;
                CHECK(solution->positions == expected);
            }
        }
    }

    TEST_CASE("a lone voxel keeps its shape with the default options") {
        const Prepared problem(makeGrid({1, 1, 1}, 1, [](const Vec3i&) { return 1; }));
        const auto solution = minimize(problem.energy, {}, {});
        REQUIRE(solution);
        CHECK(maxDifference(solution->positions, problem.energy.restPositions()) < 0.02);
    }

    TEST_CASE("empty surface: nothing to do") {
        const Prepared problem(makeGrid({2, 2, 2}, 1, [](const Vec3i&) { return 0; }));
        for (const SolveOptions& options : {SolveOptions{}, freely(SolverKind::pcg)}) {
            const auto solution = minimize(problem.energy, options, {});
            REQUIRE(solution);
            CHECK(solution->positions.empty());
            CHECK(solution->converged);
        }
    }

    TEST_CASE("reject: solvers that cannot keep a limit, and what is too large to factorize") {
        const Prepared problem(ballGrid(8, 3));
        for (const SolverKind solver : {SolverKind::pcg, SolverKind::cholesky}) {
            const auto solution = minimize(problem.energy, {.solver = solver}, {});
            REQUIRE_FALSE(solution);
            CHECK(solution.error().code == ErrorCode::invalidOption);
            CHECK(solution.error().field == "/options/solver");
        }
        const Prepared large(ballGrid(80, 38));
        const auto solution = minimize(large.energy, freely(SolverKind::cholesky), {});
        REQUIRE_FALSE(solution);
        CHECK(solution.error().code == ErrorCode::tooLarge);
        CHECK(solution.error().limit == kMaxCholeskyPointels);
    }

    TEST_CASE("reports: an iteration limit is not convergence, and a stop is an error") {
        const Prepared problem(sectorGrid(16, 6.5));
        const auto few = minimize(problem.energy, {.maxIterations = 3}, {});
        REQUIRE(few);
        CHECK_FALSE(few->converged);
        CHECK(few->residual > 1e-6);
        int polls = 0;
        const RunContext run{.stopRequested = [&] { return ++polls > 5; }};
        const auto stopped = minimize(problem.energy, {}, run);
        REQUIRE_FALSE(stopped);
        CHECK(stopped.error().code == ErrorCode::cancelled);
    }
}
