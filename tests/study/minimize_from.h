#pragma once

#include <optional>

#include "core/energy/energy.h"

namespace rivage::study {

using namespace rivage::core;

/// Minimizes the energy with other rest positions than the lattice's:
/// sum_i alpha_i |x_i - rest_i|^2 takes the place of its data term.
/// @param limit  keeps |x_i - p_i|_inf at most this, p the lattice positions
/// @return  to a relative residual (with a limit: a projected gradient) of 1e-6
/// @source  conjugate gradients; projected gradients with momentum and restarts
[[nodiscard]] PointelVectors minimizeFrom(const Energy& energy, const PointelVectors& rest,
                                          std::optional<double> limit);

}  // namespace rivage::study
