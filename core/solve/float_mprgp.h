#pragma once

#include "core/solve/preconditioner.h"

namespace rivage::core {

/// Minimizes e^T H e / 2 + g^T e in a box, lo <= e <= hi, in float: projected gradients with
/// momentum find most of the sides that the minimizer touches, then modified proportioning with
/// reduced gradient projections (MPRGP), a conjugate gradient method that changes its active set as
/// it goes.
///
/// The inner loop of iterative refinement: the caller measures g in double at some point, and gives
/// the box as seen from there. A coordinate with lo = hi = 0 is held.
/// @source [DS05] for MPRGP; [VFL18] for the momentum, its growth and its projection are ours
class FloatMprgp {
public:
    FloatMprgp(const Energy& energy, FloatOperator& operation, Preconditioner& preconditioner);

    /// Goes to e = 0. Then come steps with momentum, ended by `measure`, or none; then `begin`.
    void start(const FloatVectors& lo, const FloatVectors& hi, const FloatVectors& gradient);
    /// A projected gradient step with momentum.
    void approachStep();
    /// Ends the approach: the gradient and the residual at e.
    void measure();
    /// Begins MPRGP at e.
    void begin() { restart(); }
    /// One step of MPRGP.
    /// @return operator applications; 0 if rounding has used up the precision
    int step();
    /// |projected gradient|^2, 0 exactly where the KKT conditions hold.
    [[nodiscard]] double residual() const { return residual_; }
    [[nodiscard]] const FloatVectors& correction() const { return e_; }
    /// The energy less that at e = 0, as of the last `measure` or `step`.
    [[nodiscard]] double energy() const;

private:
    /// How much of the last move is repeated, where the gradient is taken, and the step.
    struct Momentum {
        float carry, look, step;
    };
    [[nodiscard]] Momentum nextMomentum();
    void chooseMetric(const Energy& energy);
    void judge();
    void restart();
    void recomputeGradient();
    int conjugateStep();
    int expand(float best, float feasible);
    int proportioningStep();

    struct Lengths;
    [[nodiscard]] Lengths lengthsAlong() const;
    [[nodiscard]] Lanes freeGradient(std::size_t i) const;
    [[nodiscard]] Lanes choppedGradient(std::size_t i) const;
    [[nodiscard]] Lanes clamped(std::size_t i, const Lanes& e) const;

    std::size_t size_;
    Workers workers_;
    FloatOperator& operation_;
    Preconditioner& preconditioner_;
    FloatVectors inverseMetric_;
    FloatVectors lo_;
    FloatVectors hi_;
    FloatVectors startGradient_;
    FloatVectors e_;
    FloatVectors g_;
    FloatVectors p_;  // the direction; while there is momentum, the last e
    FloatVectors q_;
    FloatVectors work_;
    double momentum_ = 1;
    double mostMomentum_ = 0;
    double residual_ = 0;
    double rz_ = 0;
    bool proportional_ = true;
};

}  // namespace rivage::core
