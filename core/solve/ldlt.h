#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "core/base/run_context.h"

namespace rivage::core {

/// The factorization L D L^T of a sparse symmetric positive definite matrix, row after row, so
/// that it can be stopped: that of Eigen cannot.
/// @source Davis, Direct Methods for Sparse Linear Systems, 2006, chapter 4: elimination tree,
///         up-looking factorization
class Ldlt {
public:
    using Sparse = Eigen::SparseMatrix<double>;

    /// @param upper  the upper triangle, columns compressed and sorted, with the whole diagonal
    /// @cost  O(sum over the columns of L of (entries)^2) time; 12 bytes an entry of L
    Ldlt(const Sparse& upper, const RunContext& run);

    /// False if a pivot is not positive, or `run` asked to stop.
    [[nodiscard]] bool complete() const { return complete_; }
    /// The solution of A x = b.
    [[nodiscard]] Eigen::VectorXd solve(Eigen::VectorXd b) const;

private:
    bool findTree(const Sparse& upper, const RunContext& run);
    bool factorize(const Sparse& upper, const RunContext& run);

    int size_;
    bool complete_ = false;
    std::vector<int> parent_;         // in the elimination tree, -1 for a root
    std::vector<std::size_t> start_;  // columns of L without the diagonal
    std::vector<int> rows_;
    std::vector<double> values_;
    std::vector<double> diagonal_;
};

}  // namespace rivage::core
