#include "core/solve/minimize.h"

#include "core/solve/cholesky.h"
#include "core/solve/gradient_descent.h"
#include "core/solve/pcg.h"
#include "core/solve/projected.h"
#include "core/solve/step_watch.h"

namespace rivage::core {
namespace {

Result<SolverKind> chooseSolver(const Energy& energy, const SolveOptions& options,
                                const Start& start) {
    const bool boxed = options.displacementLimit.has_value() || start.rooms != nullptr;
    const bool held = start.held != nullptr;
    if (options.solver == SolverKind::automatic)
        return boxed ? SolverKind::projected : SolverKind::multigrid;
    const bool linear = options.solver == SolverKind::pcg ||
                        options.solver == SolverKind::multigrid ||
                        options.solver == SolverKind::cholesky;
    if (boxed && linear)
        return fail(ErrorCode::invalidOption,
                    "this solver does not honour a displacement limit; give "
                    "displacement_limit=none, or solver=projected",
                    "/options/solver");
    if (options.solver == SolverKind::cholesky && held)
        return fail(ErrorCode::invalidOption, "this solver cannot hold a part of the surface",
                    "/options/solver");
    if (options.solver == SolverKind::cholesky && energy.size() > kMaxCholeskyPointels)
        return fail(Error{ErrorCode::tooLarge, "solver=cholesky is a reference for small surfaces",
                          "/options/solver", kMaxCholeskyPointels, energy.size()});
    return options.solver;
}

}  // namespace

Result<Solution> minimize(const Energy& energy, const SolveOptions& options, const RunContext& run,
                          const Start& start, const Observer& observer) {
    const auto solver = chooseSolver(energy, options, start);
    if (!solver) return fail(solver.error());
    if (observer) observer(0, start.positions ? *start.positions : energy.restPositions());
    StepWatch watch(observer, run);
    DisplacementSystem system(energy);
    if (run.stopped()) return fail(run.stopError());
    const Boxes boxes(energy.surface(), options.displacementLimit, start.held, start.rooms);
    Result<Solution> solution;
    switch (*solver) {
        case SolverKind::automatic:
        case SolverKind::projected:
            solution = solveProjected(system, boxes, options, run, {start.positions, watch});
            break;
        case SolverKind::accelerated:
            solution = solveAccelerated(system, boxes, options, run, {start.positions, watch});
            break;
        case SolverKind::pcg:
        case SolverKind::multigrid:
            solution = solvePcg(system, boxes, *solver == SolverKind::multigrid, options, run,
                                {start.positions, watch});
            break;
        case SolverKind::gradientDescent:
            solution = solveGradientDescent(system, boxes, options, run, {start.positions, watch});
            break;
        case SolverKind::cholesky: solution = solveCholesky(system, boxes, run); break;
    }
    if (run.stopped()) return fail(run.stopError());
    return solution;
}

}  // namespace rivage::core
