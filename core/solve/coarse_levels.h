#pragma once

#include <array>
#include <vector>

#include "core/energy/float_operator.h"

namespace rivage::core {

/// The coarse part of an additive multilevel preconditioner: on each level, the pointels of a
/// connected piece of a 2^l box move together, and a 3x3 block per piece says how stiffly.
///
/// With the inverse diagonal blocks of the pointels it makes a symmetric positive definite
/// approximation of H^-1 that also reaches long waves, so conjugate gradients need a third of the
/// iterations. Where coordinates are held, r is 0 there and the result is to be masked: that keeps
/// it symmetric.
/// @source SOLVER.md (BPX; blocks summed over the linels that leave a piece); [BPX90]
class CoarseLevels {
public:
    /// @cost O(pointels) time in all; 30 bytes a pointel, 200 while it is built. If `run` asks to
    ///       stop, levels are missing.
    CoarseLevels(const Energy& energy, const FloatOperator& operation, const RunContext& run);

    /// Finds (sum over the levels of P D^-1 P^T) r, see `correction`.
    /// @return its product with r
    double solve(const FloatVectors& r);
    /// What `solve` found for a pointel.
    [[nodiscard]] const Lanes& correction(std::size_t i) const {
        const Level& finest = levels_.front();
        return finest.correction[finest.parent[i]].lanes;
    }
    /// False for a surface too small to have coarse levels: then there is no correction.
    [[nodiscard]] bool any() const { return !levels_.empty(); }

private:
    struct Level {
        std::vector<std::uint32_t> parent;   // piece of each piece of the level below
        std::vector<std::uint32_t> start;    // members_[start[i] .. start[i + 1]) are piece i's
        std::vector<std::uint32_t> members;  // pieces of the level below, ascending
        std::vector<Symmetric3> inverse;
        std::vector<Float4> sum;
        std::vector<Float4> correction;
    };
    struct Graph;

    void addLevel(Graph& graph);

    Workers workers_;
    std::vector<Level> levels_;  // finest first
};

}  // namespace rivage::core
