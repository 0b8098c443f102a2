#include "core/solve/projected.h"

#include <Eigen/LU>

namespace rivage::core {
namespace {

// Enough to find most of the active set; more only repeat what conjugate gradients do faster.
constexpr int kApproachSteps = 100;

class Mprgp {
public:
    Mprgp(DisplacementSystem& system, const Box& box)
        : system_(system),
          box_(box),
          majorizer_(system.energy().majorizer()),
          blocks_(system.energy().diagonalBlocks()),
          inverses_(system.size()),
          d_(system.size(), Vec3d::Zero()),
          g_(system.size()),
          direction_(system.size()),
          product_(system.size()),
          work_(system.size()) {
        system_.forEach([&](PointelId i) {
            inverses_[i] = blocks_[i].inverse();
            g_[i] = -system_.rightSide()[i];
        });
        measure();
    }

    /// Accelerated projected gradient steps, restarted where they overshoot: they find most of the
    /// active set in far fewer steps than conjugate gradients, which stop at every side.
    /// @source Nesterov; [OC15] for the restart
    /// @return operator applications
    int approach(int steps, Convergence& convergence) {
        PointelVectors& ahead = direction_;
        ahead = d_;
        double momentum = 1;
        int done = 0;
        while (done < steps && convergence.goOn(residual_, done)) {
            ++done;
            const PointelVectors& last = d_;
            system_.apply(ahead, product_);
            system_.forEach([&](PointelId i) {
                work_[i] =
                    box_.project(ahead[i] - (product_[i] - system_.rightSide()[i]) / majorizer_[i]);
            });
            const double overshoot = system_.sum(0.0, [&](PointelId i) {
                return majorizer_[i] * (ahead[i] - work_[i]).dot(work_[i] - last[i]);
            });
            const double next =
                overshoot > 0 ? 1 : (1 + std::sqrt(1 + 4 * momentum * momentum)) / 2;
            const double carry = overshoot > 0 ? 0 : (momentum - 1) / next;
            momentum = next;
            system_.forEach([&](PointelId i) {
                ahead[i] = work_[i] + carry * (work_[i] - d_[i]);
                d_[i] = work_[i];
            });
        }
        system_.gradient(d_, g_);
        restart();
        measure();
        return done;
    }

    [[nodiscard]] const PointelVectors& displacement() const { return d_; }
    /// Norm of the projected gradient: 0 exactly where the KKT conditions hold.
    [[nodiscard]] double residual() const { return residual_; }
    /// One step; counts its operator applications.
    int step() {
        const int applications = proportional_ ? conjugateStep() : proportioningStep();
        measure();
        return applications;
    }

private:
    static constexpr double kStep = 1.9;  // of at most 2 / |M^-1 H| = 2, METHOD.md 2.2

    [[nodiscard]] Vec3d freeGradient(PointelId i) const { return box_.freeGradient(d_[i], g_[i]); }
    [[nodiscard]] Vec3d choppedGradient(PointelId i) const {
        return box_.choppedGradient(d_[i], g_[i]);
    }

    // The free gradient, cut to what a projected step of length kStep / m can really move.
    [[nodiscard]] Vec3d reducedGradient(PointelId i, const Vec3d& free) const {
        const double scale = kStep / majorizer_[i];
        return (d_[i] - box_.project(d_[i] - scale * free)) / scale;
    }

    // The residual, and whether the free components still have more to give than the chopped ones,
    // in the metric of the majorizer.
    void measure() {
        const Eigen::Array3d sums =
            system_.sum(Eigen::Array3d(Eigen::Array3d::Zero()), [&](PointelId i) {
                const Vec3d free = freeGradient(i);
                const double chopped = choppedGradient(i).squaredNorm();
                return Eigen::Array3d(free.squaredNorm() + chopped, chopped / majorizer_[i],
                                      reducedGradient(i, free).dot(free) / majorizer_[i]);
            });
        residual_ = std::sqrt(sums[0]);
        proportional_ = sums[1] <= sums[2];
    }

    // The inverse of the free part of the diagonal block, 0 elsewhere.
    [[nodiscard]] Vec3d precondition(PointelId i) const {
        if (box_.inside(d_[i])) return inverses_[i] * g_[i];
        Mat3d block = blocks_[i];
        for (int k = 0; k < 3; ++k) {
            if (!box_.active(d_[i][k])) continue;
            block.row(k).setZero();
            block.col(k).setZero();
            block(k, k) = 1;
        }
        return block.inverse() * freeGradient(i);
    }

    void restart() {
        system_.forEach([&](PointelId i) { direction_[i] = precondition(i); });
    }

    // `wanted`, or the largest step that stays in the box if that is less.
    [[nodiscard]] double feasibleStep(double wanted) const {
        struct Smallest {
            double value;
            Smallest operator+(const Smallest& other) const {
                return {std::min(value, other.value)};
            }
        };
        return system_
            .sum(Smallest{wanted},
                 [&](PointelId i) {
                     return Smallest{box_.feasibleStep(d_[i], direction_[i], wanted)};
                 })
            .value;
    }

    void move(double step) {
        system_.forEach([&](PointelId i) {
            // Rounding must not leave a component just inside or outside its side.
            d_[i] = box_.project(d_[i] - step * direction_[i]);
            g_[i] -= step * product_[i];
        });
    }

    int conjugateStep() {
        system_.apply(direction_, product_);
        const double curvature = system_.dot(direction_, product_);
        const double best = system_.dot(direction_, g_) / curvature;
        const double feasible = feasibleStep(best);
        if (best > feasible) return 1 + expand(best, feasible);
        move(best);
        PointelVectors& z = work_;
        system_.forEach([&](PointelId i) { z[i] = precondition(i); });
        const double keep = system_.dot(z, product_) / curvature;
        system_.forEach([&](PointelId i) { direction_[i] = z[i] - keep * direction_[i]; });
        return 1;
    }

    // The step of the conjugate gradients, projected: it may reach many sides at once. Where that
    // does not lower the energy, the step that always does: to the first side, then a projected
    // gradient step.
    int expand(double best, double feasible) {
        const PointelVectors start = d_;
        const PointelVectors startGradient = g_;
        const double before = energy();
        system_.forEach([&](PointelId i) { d_[i] = box_.project(d_[i] - best * direction_[i]); });
        system_.gradient(d_, g_);
        if (energy() < before) {
            restart();
            return 1;
        }
        d_ = start;
        g_ = startGradient;
        move(feasible);
        system_.forEach([&](PointelId i) {
            d_[i] = box_.project(d_[i] - kStep / majorizer_[i] * freeGradient(i));
        });
        system_.gradient(d_, g_);
        restart();
        return 2;
    }

    // Half the energy less that of the rest positions.
    [[nodiscard]] double energy() const {
        return system_.sum(
            0.0, [&](PointelId i) { return 0.5 * d_[i].dot(g_[i] - system_.rightSide()[i]); });
    }

    // Releases active components along the chopped gradient.
    int proportioningStep() {
        system_.forEach([&](PointelId i) { direction_[i] = choppedGradient(i) / majorizer_[i]; });
        system_.apply(direction_, product_);
        const double best = system_.dot(direction_, g_) / system_.dot(direction_, product_);
        move(feasibleStep(best));
        restart();
        return 1;
    }

    DisplacementSystem& system_;
    const Box& box_;
    IdVector<PointelId, double> majorizer_;
    IdVector<PointelId, Mat3d> blocks_;
    IdVector<PointelId, Mat3d> inverses_;
    PointelVectors d_;
    PointelVectors g_;  // H d - b
    PointelVectors direction_;
    PointelVectors product_;  // H direction
    PointelVectors work_;
    double residual_ = 0;
    bool proportional_ = true;
};

}  // namespace

Solution solveProjected(DisplacementSystem& system, const Box& box, const SolveOptions& options,
                        const RunContext& run) {
    Mprgp mprgp(system, box);
    Convergence convergence(mprgp.residual(), options, run);
    int iterations = mprgp.approach(kApproachSteps, convergence);
    while (convergence.goOn(mprgp.residual(), iterations)) iterations += mprgp.step();
    return {system.positions(mprgp.displacement()), "projected", iterations, convergence.relative(),
            convergence.reached()};
}

}  // namespace rivage::core
