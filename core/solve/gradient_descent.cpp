#include "core/solve/gradient_descent.h"

namespace rivage::core {

Solution solveGradientDescent(DisplacementSystem& system, const Box& box,
                              const SolveOptions& options, const RunContext& run) {
    const IdVector<PointelId, double> majorizer = system.energy().majorizer();
    PointelVectors d(system.size(), Vec3d::Zero());
    PointelVectors g(system.size());
    const auto projectedNorm = [&] {
        return std::sqrt(system.sum(0.0, [&](PointelId i) {
            return (box.freeGradient(d[i], g[i]) + box.choppedGradient(d[i], g[i])).squaredNorm();
        }));
    };

    system.gradient(d, g);
    Convergence convergence(projectedNorm(), options, run);
    int iterations = 0;
    while (convergence.goOn(projectedNorm(), iterations)) {
        ++iterations;
        system.forEach([&](PointelId i) { d[i] = box.project(d[i] - g[i] / majorizer[i]); });
        system.gradient(d, g);
    }
    return {system.positions(d), "gradient-descent", iterations, convergence.relative(),
            convergence.reached()};
}

}  // namespace rivage::core
