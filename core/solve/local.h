#pragma once

#include <span>

#include "core/solve/minimize.h"

namespace rivage::core {

/// What `reminimizeAround` did.
struct LocalSolution {
    PointelVectors positions;  ///< voxel units
    std::size_t touched = 0;   ///< pointels that were free to move
    int iterations = 0;
    bool converged = true;  ///< the residual of the part solved is at most the tolerance
    /// |projected gradient| of the pointels just outside, relative to that of the rest positions:
    /// what the solution everywhere would still change there.
    double rimResidual = 0;
};

/// Minimizes the energy again after its weights or normals changed near some pointels: solves for
/// the pointels within 10 sqrt(beta / alpha) voxels of them, and keeps all others where they are.
/// Away from an edit its effect falls off by e every sqrt(2 beta / alpha) voxels.
///
/// @param energy    with the weights and normals as they are now
/// @param previous  its minimizer before the edit
/// @param changed   pointels whose own terms, or whose surfels, changed
/// @errors as `minimize`; `cholesky` is refused
/// @cost   that of `minimize` for the part, and O(pointels) to find it
/// @source METHOD.md 6; the reach is ours, as 5 sqrt(beta / alpha) left 0.01 voxel in the test
Result<LocalSolution> reminimizeAround(const Energy& energy, const PointelVectors& previous,
                                       std::span<const PointelId> changed,
                                       const SolveOptions& options, const RunContext& run);

}  // namespace rivage::core
