#pragma once

#include "core/solve/displacement_system.h"

namespace rivage::core {

/// The exact minimizer without a displacement limit: conjugate gradients, preconditioned with the
/// inverse 3x3 diagonal blocks and coarse levels.
/// @source METHOD.md 2.5, SOLVER.md
Solution solvePcg(DisplacementSystem& system, const SolveOptions& options, const RunContext& run);

}  // namespace rivage::core
