#pragma once

#include "core/solve/coarse_levels.h"

namespace rivage::core {

/// An approximate inverse of H on the coordinates that are free: the inverse 3x3 blocks of the
/// free coordinates and, if wanted, coarse levels. Symmetric and positive definite there.
class Preconditioner {
public:
    /// @param coarse  nullptr for the blocks alone
    Preconditioner(const Energy& energy, const FloatOperator& operation, CoarseLevels* coarse);

    /// @param free  which coordinates may move, a lane of 1 or 0 each
    void setFree(const FloatVectors& free);
    [[nodiscard]] const FloatVectors& free() const { return free_; }
    /// Finds z = P r, see `result`. Held coordinates of r do not count without coarse levels, and
    /// must be 0 with them.
    /// @return r . z
    double apply(const FloatVectors& r);
    [[nodiscard]] Lanes result(std::size_t i) const {
        const Lanes z = local_.raw()[i].lanes;
        return coarse_ == nullptr ? z : z + coarse_->correction(i) * free_.raw()[i].lanes;
    }
    [[nodiscard]] const IdVector<PointelId, Symmetric3>& blocks() const { return blocks_; }

private:
    Workers workers_;
    CoarseLevels* coarse_ = nullptr;
    IdVector<PointelId, Symmetric3> blocks_;
    IdVector<PointelId, Symmetric3> inverses_;
    FloatVectors free_;
    FloatVectors local_;
};

}  // namespace rivage::core
