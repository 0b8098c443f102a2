#pragma once

#include "core/solve/refinement.h"

namespace rivage::core {

/// The exact minimizer in the box, to its KKT conditions: projected gradients with momentum, then
/// MPRGP, in float (`FloatMprgp`) inside iterative refinement in double.
/// @source METHOD.md 7.2
Solution solveProjected(DisplacementSystem& system, const Boxes& boxes, const SolveOptions& options,
                        const RunContext& run, const PointelVectors* start);

/// Projected gradients with momentum alone: a good surface after 10 to 50 steps, for previews. Runs
/// `maxIterations` steps unless the tolerance, which it looks at now and then, is reached earlier.
Solution solveAccelerated(DisplacementSystem& system, const Boxes& boxes,
                          const SolveOptions& options, const RunContext& run,
                          const PointelVectors* start);

}  // namespace rivage::core
