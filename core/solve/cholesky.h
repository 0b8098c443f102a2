#pragma once

#include "core/solve/displacement_system.h"

namespace rivage::core {

/// The exact minimizer without a displacement limit by sparse Cholesky factorization of the
/// assembled matrix: the reference for small surfaces.
/// @errors internal if the factorization breaks down; cancelled
Result<Solution> solveCholesky(DisplacementSystem& system, const RunContext& run);

}  // namespace rivage::core
