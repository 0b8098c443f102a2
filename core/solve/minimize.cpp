#include "core/solve/minimize.h"

#include "core/solve/cholesky.h"
#include "core/solve/gradient_descent.h"
#include "core/solve/pcg.h"
#include "core/solve/projected.h"

namespace rivage::core {
namespace {

Result<SolverKind> chooseSolver(const Energy& energy, const SolveOptions& options) {
    const bool boxed = options.displacementLimit.has_value();
    if (options.solver == SolverKind::automatic)
        return boxed ? SolverKind::projected : SolverKind::pcg;
    const bool direct = options.solver == SolverKind::pcg || options.solver == SolverKind::cholesky;
    if (boxed && direct)
        return fail(ErrorCode::invalidOption,
                    "this solver does not honour a displacement limit; give "
                    "displacement_limit=none, or solver=projected",
                    "/options/solver");
    if (options.solver == SolverKind::cholesky && energy.size() > kMaxCholeskyPointels)
        return fail(Error{ErrorCode::tooLarge, "solver=cholesky is a reference for small surfaces",
                          "/options/solver", kMaxCholeskyPointels, energy.size()});
    return options.solver;
}

}  // namespace

Result<Solution> minimize(const Energy& energy, const SolveOptions& options,
                          const RunContext& run) {
    const auto solver = chooseSolver(energy, options);
    if (!solver) return fail(solver.error());
    DisplacementSystem system(energy);
    Box box;
    if (options.displacementLimit) box.limit = *options.displacementLimit;
    Result<Solution> solution;
    switch (*solver) {
        case SolverKind::automatic:
        case SolverKind::projected: solution = solveProjected(system, box, options, run); break;
        case SolverKind::pcg: solution = solvePcg(system, options, run); break;
        case SolverKind::gradientDescent:
            solution = solveGradientDescent(system, box, options, run);
            break;
        case SolverKind::cholesky: solution = solveCholesky(system, run); break;
    }
    if (run.stopped()) return fail(run.stopError());
    return solution;
}

}  // namespace rivage::core
