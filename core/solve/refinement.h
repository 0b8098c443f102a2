#pragma once

#include "core/energy/lanes.h"
#include "core/solve/box.h"
#include "core/solve/displacement_system.h"

namespace rivage::core {

/// The outer loop of iterative refinement: a displacement in double, inside its boxes, whose
/// gradient is measured in double and corrected by solvers that run in float. So the residual is
/// honest, and the limits hold to the last bit.
class Refinement {
public:
    /// @param start  positions to begin at, taken into the boxes; nullptr for the rest positions
    Refinement(DisplacementSystem& system, const Boxes& boxes, const PointelVectors* start);

    /// Computes the gradient.
    /// @return norm of the projected gradient
    double measure();
    /// That norm at the rest positions, which relative residuals refer to.
    [[nodiscard]] double initial() const { return initial_; }
    [[nodiscard]] const PointelVectors& displacement() const { return d_; }
    [[nodiscard]] PointelVectors positions() const { return system_.positions(d_); }

    /// The gradient as measured, and its opposite with 0 where coordinates are held.
    void gradient(FloatVectors& g) const;
    void residual(FloatVectors& r) const;
    /// 1 for the coordinates that may move, 0 for those that are held.
    void movable(FloatVectors& free) const;
    /// How far the displacement may go down and up from here.
    void room(FloatVectors& lo, FloatVectors& hi) const;
    /// A projected gradient step of length 1 / m_i, in double.
    void descend(const IdVector<PointelId, double>& m);
    /// Goes back to an earlier displacement.
    void reset(const PointelVectors& d) { d_ = d; }
    /// Adds a correction; a coordinate that used up its room lands on its side exactly.
    void add(const FloatVectors& correction);
    /// What `positions` would be after `add`.
    [[nodiscard]] PointelVectors positionsWith(const FloatVectors& correction) const;

private:
    DisplacementSystem& system_;
    const Boxes& boxes_;
    PointelVectors d_;
    PointelVectors g_;
    double initial_ = 0;
};

}  // namespace rivage::core
