#include "core/solve/projected.h"

#include <Eigen/LU>

namespace rivage::core {
namespace {

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
          product_(system.size()) {
        system_.forEach([&](PointelId i) {
            inverses_[i] = blocks_[i].inverse();
            g_[i] = -system_.rightSide()[i];
        });
        restart();
    }

    [[nodiscard]] const PointelVectors& displacement() const { return d_; }
    /// Norm of the projected gradient: 0 exactly where the KKT conditions hold.
    [[nodiscard]] double residual() const {
        return std::sqrt(system_.sum(0.0, [&](PointelId i) {
            return (freeGradient(i) + choppedGradient(i)).squaredNorm();
        }));
    }
    /// One step; counts its operator applications.
    int step() { return isProportional() ? conjugateStep() : proportioningStep(); }

private:
    static constexpr double kStep = 1.9;  // of at most 2 / |M^-1 H| = 2, METHOD.md 2.2

    [[nodiscard]] Vec3d freeGradient(PointelId i) const {
        return box_.freeGradient(d_[i], g_[i]);
    }
    [[nodiscard]] Vec3d choppedGradient(PointelId i) const {
        return box_.choppedGradient(d_[i], g_[i]);
    }

    // The free gradient, cut to what a projected step of length kStep / m can really move.
    [[nodiscard]] Vec3d reducedGradient(PointelId i) const {
        const Vec3d free = freeGradient(i);
        const double scale = kStep / majorizer_[i];
        return (d_[i] - box_.project(d_[i] - scale * free)) / scale;
    }

    // Whether the free components still have more to give than the chopped ones, in the metric of
    // the majorizer.
    [[nodiscard]] bool isProportional() const {
        const Eigen::Array2d sums =
            system_.sum(Eigen::Array2d(Eigen::Array2d::Zero()), [&](PointelId i) {
                return Eigen::Array2d(
                    Eigen::Array2d(choppedGradient(i).squaredNorm(),
                                   reducedGradient(i).dot(freeGradient(i))) /
                    majorizer_[i]);
            });
        return sums[0] <= sums[1];
    }

    // The inverse of the free part of the diagonal block, 0 elsewhere.
    [[nodiscard]] Vec3d precondition(PointelId i) const {
        const Vec3d free = freeGradient(i);
        bool anyActive = false;
        Mat3d block = blocks_[i];
        for (int k = 0; k < 3; ++k) {
            if (!box_.active(d_[i][k])) continue;
            anyActive = true;
            block.row(k).setZero();
            block.col(k).setZero();
            block(k, k) = 1;
        }
        return anyActive ? Vec3d(block.inverse() * free) : Vec3d(inverses_[i] * free);
    }

    void restart() {
        system_.forEach([&](PointelId i) { direction_[i] = precondition(i); });
    }

    [[nodiscard]] double feasibleStep() const {
        struct Smallest {
            double value = std::numeric_limits<double>::infinity();
            Smallest operator+(const Smallest& other) const {
                return {std::min(value, other.value)};
            }
        };
        return system_
            .sum(Smallest{},
                 [&](PointelId i) {
                     return Smallest{box_.feasibleStep(d_[i], direction_[i])};
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
        const double feasible = feasibleStep();
        if (best > feasible) return 1 + expand(feasible);
        move(best);
        PointelVectors& z = work_;
        z.resize(system_.size());
        system_.forEach([&](PointelId i) { z[i] = precondition(i); });
        const double keep = system_.dot(z, product_) / curvature;
        system_.forEach([&](PointelId i) { direction_[i] = z[i] - keep * direction_[i]; });
        return 1;
    }

    // To the side of the box, then a projected gradient step that may add many active components.
    int expand(double feasible) {
        move(feasible);
        system_.forEach([&](PointelId i) {
            d_[i] = box_.project(d_[i] - kStep / majorizer_[i] * freeGradient(i));
        });
        system_.apply(d_, g_);
        system_.forEach([&](PointelId i) { g_[i] -= system_.rightSide()[i]; });
        restart();
        return 1;
    }

    // Releases active components along the chopped gradient.
    int proportioningStep() {
        system_.forEach(
            [&](PointelId i) { direction_[i] = choppedGradient(i) / majorizer_[i]; });
        system_.apply(direction_, product_);
        const double best = system_.dot(direction_, g_) / system_.dot(direction_, product_);
        move(std::min(best, feasibleStep()));
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
};

}  // namespace

Solution solveProjected(DisplacementSystem& system, const Box& box, const SolveOptions& options,
                        const RunContext& run) {
    Mprgp mprgp(system, box);
    Convergence convergence(mprgp.residual(), options, run);
    int iterations = 0;
    while (convergence.goOn(mprgp.residual(), iterations)) iterations += mprgp.step();
    return {system.positions(mprgp.displacement()), "projected", iterations,
            convergence.relative(), convergence.reached()};
}

}  // namespace rivage::core
