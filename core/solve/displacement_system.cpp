#include "core/solve/displacement_system.h"

#include <algorithm>
#include <cmath>

namespace rivage::core {

DisplacementSystem::DisplacementSystem(const Energy& energy)
    : energy_(energy), rightSide_(energy.restForce()) {}

void DisplacementSystem::gradient(const PointelVectors& d, PointelVectors& out) {
    apply(d, out);
    forEach([&](PointelId i) { out[i] -= rightSide_[i]; });
}

PointelVectors DisplacementSystem::positions(const PointelVectors& d) const {
    PointelVectors x = energy_.restPositions();
    forEach([&](PointelId i) { x[i] += d[i]; });
    return x;
}

Convergence::Convergence(double initial, const SolveOptions& options, const RunContext& run)
    : initial_(initial), options_(options), run_(run) {}

bool Convergence::goOn(double residual, int iterations) {
    // A surface whose rest positions are the minimum has nothing to reduce.
    relative_ = initial_ > 0 ? residual / initial_ : 0;
    const double done = relative_ > 0 ? std::log(relative_) / std::log(options_.tolerance) : 1;
    run_.report(Stage::solve, std::clamp(done, 0.0, 1.0));
    return !reached() && iterations < options_.maxIterations && !run_.stopped();
}

}  // namespace rivage::core
