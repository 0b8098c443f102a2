#pragma once

#include <vector>

#include "core/energy/energy.h"

namespace rivage::core {

/// The coarse part of an additive multilevel preconditioner: on each level, the pointels of a
/// connected piece of a 2^l box move together, and a 3x3 block per piece says how stiffly.
///
/// With the inverse diagonal blocks of the pointels it makes a symmetric positive definite
/// approximation of H^-1 that also reaches long waves, so conjugate gradients need a third of the
/// iterations.
/// @source SOLVER.md (BPX with Galerkin diagonals); [BPX90]
class CoarseLevels {
public:
    /// @cost O(pointels) a level, about log2 of the surface's extent levels; 20 bytes a pointel
    explicit CoarseLevels(const Energy& energy);

    /// z += (sum over the levels of P D^-1 P^T) r
    void add(const PointelVectors& r, PointelVectors& z);

private:
    struct Level {
        std::vector<std::uint32_t> parent;   // piece of each piece of the level below
        std::vector<std::uint32_t> start;    // members_[start[i] .. start[i + 1]) are piece i's
        std::vector<std::uint32_t> members;  // pieces of the level below, ascending
        std::vector<Mat3d> inverse;
        std::vector<Vec3d> correction;
    };

    void addLevel(const Energy& energy, const std::vector<std::uint32_t>& below,
                  const std::vector<std::uint32_t>& pieces, std::size_t pieceCount);

    int threads_;
    std::vector<Level> levels_;  // finest first
};

}  // namespace rivage::core
