#include "core/solve/gradient_descent.h"

namespace rivage::core {

Solution solveGradientDescent(DisplacementSystem& system, const Boxes& boxes,
                              const SolveOptions& options, const RunContext& run,
                              const Begin& begin) {
    const IdVector<PointelId, double> majorizer = system.energy().majorizer();
    Refinement refinement(system, boxes, begin.positions);
    Convergence convergence(refinement.initial(), options, run);
    int iterations = 0;
    while (convergence.goOn(refinement.measure(), iterations)) {
        ++iterations;
        refinement.descend(majorizer);
        begin.watch.step([&] { return refinement.positions(); });
    }
    return {refinement.positions(), "gradient-descent", iterations, convergence.relative(),
            convergence.reached()};
}

}  // namespace rivage::core
