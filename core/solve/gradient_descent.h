#pragma once

#include "core/solve/refinement.h"
#include "core/solve/step_watch.h"

namespace rivage::core {

/// Projected gradient descent with the step 1 / m_i of the majorizer: the energy never increases.
/// Slow to the end, and the plainest correct method: a reference for the others.
/// @source METHOD.md 2.2
Solution solveGradientDescent(DisplacementSystem& system, const Boxes& boxes,
                              const SolveOptions& options, const RunContext& run,
                              const Begin& begin);

}  // namespace rivage::core
