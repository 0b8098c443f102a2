#pragma once

#include "core/solve/refinement.h"
#include "core/solve/step_watch.h"

namespace rivage::core {

/// The exact minimizer in the box, to its KKT conditions: projected gradients with momentum, then
/// MPRGP, in float (`FloatMprgp`) inside iterative refinement in double.
/// @source METHOD.md 7.2
Solution solveProjected(DisplacementSystem& system, const Boxes& boxes, const SolveOptions& options,
                        const RunContext& run, const Begin& begin);

/// Projected gradients with momentum alone: a good surface after 10 to 50 steps, for previews. Runs
/// `maxIterations` steps unless the tolerance, which it looks at now and then, is reached earlier.
Solution solveAccelerated(DisplacementSystem& system, const Boxes& boxes,
                          const SolveOptions& options, const RunContext& run, const Begin& begin);

}  // namespace rivage::core
