#pragma once

#include <optional>

#include "core/energy/energy.h"

namespace rivage::study {

using namespace rivage::core;

/// Minimizes the energy with other rest positions than the lattice's:
/// sum_i alpha_i |x_i - rest_i|^2 takes the place of its data term.
/// @param limit  keeps |x_i - p_i|_inf at most this, p the lattice positions
/// @return  to a relative change of 1e-4 of the projected gradient, or after 3000 steps
/// @source  projected gradients with momentum and restarts; the majorizer of `Energy`
[[nodiscard]] PointelVectors minimizeFrom(const Energy& energy, const PointelVectors& rest,
                                          std::optional<double> limit);

}  // namespace rivage::study
