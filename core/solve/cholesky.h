#pragma once

#include "core/solve/refinement.h"

namespace rivage::core {

/// The exact minimizer without a displacement limit by sparse Cholesky factorization of the
/// assembled matrix: the reference for small surfaces. Rows of fixed coordinates are those of the
/// unit matrix.
/// @errors internal if the factorization breaks down; cancelled
Result<Solution> solveCholesky(DisplacementSystem& system, const Boxes& boxes,
                               const RunContext& run);

}  // namespace rivage::core
