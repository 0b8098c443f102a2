#include "core/solve/projected.h"

#include <optional>

#include "core/solve/float_mprgp.h"

namespace rivage::core {
namespace {

// Enough to find most of the active set; more only repeat what conjugate gradients do faster.
constexpr int kApproachSteps = 120;

/// The float solver with what it needs, begun anew at each measured displacement.
class Inner {
public:
    /// Incomplete once `run` asked to stop: all that memory would take longer to fill than a stop
    /// may.
    Inner(const Energy& energy, const RunContext& run) : operation_(energy, run) {
        if (run.stopped()) return;
        preconditioner_.emplace(energy, operation_, nullptr);
        if (run.stopped()) return;
        mprgp_.emplace(energy, operation_, *preconditioner_);
    }
    [[nodiscard]] bool complete() const { return mprgp_.has_value(); }

    FloatMprgp& startAt(const Refinement& refinement) {
        refinement.room(lo_, hi_);
        refinement.gradient(gradient_);
        mprgp_->start(lo_, hi_, gradient_);
        return *mprgp_;
    }

private:
    FloatOperator operation_;
    std::optional<Preconditioner> preconditioner_;
    std::optional<FloatMprgp> mprgp_;
    FloatVectors lo_;
    FloatVectors hi_;
    FloatVectors gradient_;
};

Solution stoppedSolution(const char* name) { return {{}, name, 0, 1, false}; }

}  // namespace

Solution solveProjected(DisplacementSystem& system, const Boxes& boxes, const SolveOptions& options,
                        const RunContext& run, const Begin& begin) {
    constexpr double kRound = 1e-4;  // reduction before the gradient is measured in double again
    Refinement refinement(system, boxes, begin.positions);
    if (run.stopped()) return stoppedSolution("projected");
    Inner inner(system.energy(), run);
    if (!inner.complete()) return stoppedSolution("projected");
    Convergence convergence(refinement.initial(), options, run);
    int iterations = 0;
    double residual = refinement.measure();
    for (int round = 0; convergence.goOn(residual, iterations); ++round) {
        FloatMprgp& mprgp = inner.startAt(refinement);
        const auto shown = [&] { return refinement.positionsWith(mprgp.correction()); };
        const double target =
            std::max(kRound * residual, 0.7 * options.tolerance * refinement.initial());
        if (round == 0) {
            for (int k = 0; k < kApproachSteps && convergence.goOn(residual, iterations); ++k) {
                mprgp.approachStep();
                ++iterations;
                begin.watch.step(shown);
            }
            mprgp.measure();
            // Momentum has no proof of descent under projection: without descent, without it.
            if (!(mprgp.energy() <= 0)) inner.startAt(refinement);
        }
        mprgp.begin();
        double reached = std::sqrt(mprgp.residual());
        while (reached > target && convergence.goOn(reached, iterations)) {
            const int applications = mprgp.step();
            if (applications == 0) break;
            iterations += applications;
            begin.watch.step(shown);
            reached = std::sqrt(mprgp.residual());
        }
        refinement.add(mprgp.correction());
        const double last = residual;
        residual = refinement.measure();
        // Double precision is used up.
        if (round > 0 && residual > 0.99 * last && reached <= target) break;
    }
    convergence.goOn(residual, iterations);
    return {refinement.positions(), "projected", iterations, convergence.relative(),
            convergence.reached()};
}

Solution solveAccelerated(DisplacementSystem& system, const Boxes& boxes,
                          const SolveOptions& options, const RunContext& run, const Begin& begin) {
    constexpr int kLookEvery = 25;  // steps; a look costs as much as five of them
    Refinement refinement(system, boxes, begin.positions);
    if (run.stopped()) return stoppedSolution("accelerated");
    Inner inner(system.energy(), run);
    if (!inner.complete()) return stoppedSolution("accelerated");
    Convergence convergence(refinement.initial(), options, run);
    int iterations = 0;
    double residual = refinement.measure();
    const PointelVectors origin = refinement.displacement();
    FloatMprgp& mprgp = inner.startAt(refinement);
    while (convergence.goOn(residual, iterations)) {
        mprgp.approachStep();
        ++iterations;
        begin.watch.step([&] {
            Refinement now = refinement;
            now.reset(origin);
            return now.positionsWith(mprgp.correction());
        });
        if (iterations % kLookEvery != 0 && iterations != options.maxIterations) continue;
        refinement.reset(origin);
        refinement.add(mprgp.correction());
        residual = refinement.measure();
    }
    return {refinement.positions(), "accelerated", iterations, convergence.relative(),
            convergence.reached()};
}

}  // namespace rivage::core
