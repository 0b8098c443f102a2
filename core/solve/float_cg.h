#pragma once

#include "core/solve/preconditioner.h"

namespace rivage::core {

/// Preconditioned conjugate gradients in float for H e = r on the free coordinates.
///
/// The inner loop of iterative refinement: the caller measures r in double, runs some steps, adds
/// the correction e, measures again, and goes on from there without losing the directions.
/// @source SOLVER.md; [VY00] for replacing the residual
class FloatCg {
public:
    FloatCg(const Energy& energy, FloatOperator& operation, Preconditioner& preconditioner);

    /// A measured residual; 0 where coordinates are held. The correction starts at 0 again.
    void setResidual(const FloatVectors& r);
    /// Forgets the directions, as is due when other coordinates are free.
    void forget() { rz_ = 0; }
    /// One operator application.
    /// @return |r|^2 as the recursion has it; negative if rounding has used up the precision
    double step();
    [[nodiscard]] const FloatVectors& correction() const { return e_; }

private:
    Workers workers_;
    FloatOperator& operation_;
    Preconditioner& preconditioner_;
    FloatVectors e_;
    FloatVectors r_;
    FloatVectors p_;
    FloatVectors q_;
    double rz_ = 0;  // of the last step; 0: none
};

}  // namespace rivage::core
