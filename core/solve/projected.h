#pragma once

#include "core/solve/box.h"
#include "core/solve/displacement_system.h"

namespace rivage::core {

/// The exact minimizer in the box, to its KKT conditions: a start with accelerated projected
/// gradients, then modified proportioning with reduced gradient projections (MPRGP), a conjugate
/// gradient method that changes its active set as it goes. Free components are preconditioned with
/// the inverses of the free parts of the 3x3 diagonal blocks; gradient steps are scaled by the
/// majorizer, so that they are safe.
/// @source [DS05], [OC15]; METHOD.md 7.2
Solution solveProjected(DisplacementSystem& system, const Box& box, const SolveOptions& options,
                        const RunContext& run);

}  // namespace rivage::core
