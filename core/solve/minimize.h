#pragma once

#include <functional>
#include <string>

#include "core/base/options.h"
#include "core/energy/energy.h"
#include "core/solve/box.h"

namespace rivage::core {

struct Solution {
    PointelVectors positions;  ///< voxel units
    std::string solver;        ///< which one ran
    int iterations = 0;
    double residual = 0;    ///< |projected gradient| relative to that of the rest positions
    bool converged = true;  ///< the residual is at most the tolerance
};

/// Where the iterative solvers begin; by default at the rest positions.
struct Start {
    const PointelVectors* positions = nullptr;  ///< of an earlier solution, say
    /// 1 for the pointels that stay at their start; nullptr for none. Not for `cholesky`.
    const IdVector<PointelId, std::uint8_t>* held = nullptr;
    /// How far each pointel may go, in place of the displacement limit; nullptr for that. Not for
    /// `pcg`, `multigrid` and `cholesky`.
    const IdVector<PointelId, Room>* rooms = nullptr;
};

/// Is given the positions at steps 0, 1, 4, 16, ... of a solver: 0 are the positions it begins at,
/// for `cholesky` there is no other. Changes nothing in the solution.
using Observer = std::function<void(int step, const PointelVectors& positions)>;

/// Minimizes the energy, inside the box |x_i - p_i|_inf <= displacementLimit if one is set.
///
/// Everything is solved for the displacement x - p, whose right-hand side is small, so that the
/// relative residual means what it says. Fixed coordinates of the surface stay where they rest.
/// @param start  for all iterative solvers; the residual is still relative to that of the rest
///               positions
/// @param observer  empty: nobody looks, at no cost
/// @errors invalidOption if `pcg`, `multigrid` or `cholesky` is asked for together with a limit;
///         tooLarge if `cholesky` is asked for a surface above `kMaxCholeskyPointels`; cancelled
/// @cost   a few hundred operator applications in float, METHOD.md 2.5 and 7.2
Result<Solution> minimize(const Energy& energy, const SolveOptions& options, const RunContext& run,
                          const Start& start = {}, const Observer& observer = {});

/// Factorization is a reference for small surfaces: its time grows with the square of the size.
inline constexpr std::size_t kMaxCholeskyPointels = 20000;

}  // namespace rivage::core
