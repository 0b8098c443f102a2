#include "core/solve/pcg.h"

#include <optional>

#include "core/solve/float_cg.h"

namespace rivage::core {

Solution solvePcg(DisplacementSystem& system, const Boxes& boxes, bool coarse,
                  const SolveOptions& options, const RunContext& run, const Begin& begin) {
    // As far as a round in float may reduce the residual before it is measured again: less, and
    // rounding would make it lie; more, and measuring would cost too much.
    constexpr double kRound = 1e-3;
    Refinement refinement(system, boxes, begin.positions);
    FloatOperator operation(system.energy(), run);
    std::optional<CoarseLevels> levels;
    if (coarse && !run.stopped()) levels.emplace(system.energy(), operation, run);
    const char* name = coarse ? "multigrid" : "pcg";
    Convergence convergence(refinement.initial(), options, run);
    const Solution stopped{{}, name, 0, 1, false};
    if (run.stopped()) return stopped;

    Preconditioner preconditioner(system.energy(), operation, levels ? &*levels : nullptr);
    if (run.stopped()) return stopped;
    FloatCg cg(system.energy(), operation, preconditioner);
    FloatVectors work(system.size());
    refinement.movable(work);
    preconditioner.setFree(work);

    int iterations = 0;
    double residual = refinement.measure();
    while (convergence.goOn(residual, iterations)) {
        refinement.residual(work);
        cg.setResidual(work);
        const double target =
            std::max(kRound * residual, 0.7 * options.tolerance * refinement.initial());
        double reached = residual;
        while (reached > target && convergence.goOn(reached, iterations)) {
            const double squared = cg.step();
            ++iterations;
            if (squared < 0) break;
            begin.watch.step([&] { return refinement.positionsWith(cg.correction()); });
            reached = std::sqrt(squared);
        }
        refinement.add(cg.correction());
        const double last = residual;
        residual = refinement.measure();
        if (residual > 0.5 * last) cg.forget();
        // Double precision is used up.
        if (residual > 0.99 * last && reached <= target) break;
    }
    convergence.goOn(residual, iterations);
    return {refinement.positions(), name, iterations, convergence.relative(),
            convergence.reached()};
}

}  // namespace rivage::core
