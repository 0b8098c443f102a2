#pragma once

#include "core/solve/refinement.h"
#include "core/solve/step_watch.h"

namespace rivage::core {

/// The exact minimizer without a displacement limit: preconditioned conjugate gradients in float
/// inside iterative refinement in double. Fixed coordinates are held.
/// @param coarse  coarse levels in the preconditioner (`multigrid`), or block Jacobi alone (`pcg`)
/// @source METHOD.md 2.5, SOLVER.md
Solution solvePcg(DisplacementSystem& system, const Boxes& boxes, bool coarse,
                  const SolveOptions& options, const RunContext& run, const Begin& begin);

}  // namespace rivage::core
