#include "core/solve/ldlt.h"

namespace rivage::core {
Ldlt::Ldlt(const Sparse& upper, const RunContext& run) : size_(static_cast<int>(upper.cols())) {
    complete_ = findTree(upper, run) && factorize(upper, run);
}

// Walks from each entry of row k up the tree that is known so far; every column passed on the way
// has an entry in row k of L.
bool Ldlt::findTree(const Sparse& upper, const RunContext& run) {
    parent_.assign(size_, -1);
    std::vector<std::size_t> counts(size_, 0);
    std::vector<int> seen(size_, -1);
    for (int k = 0; k < size_; ++k) {
        if (run.stopped()) return false;
        seen[k] = k;
        for (Sparse::InnerIterator entry(upper, k); entry; ++entry)
            for (auto i = static_cast<int>(entry.index()); i < k && seen[i] != k; i = parent_[i]) {
                if (parent_[i] == -1) parent_[i] = k;
                ++counts[i];
                seen[i] = k;
            }
    }
    start_.assign(1, 0);
    for (const std::size_t count : counts) start_.push_back(start_.back() + count);
    return true;
}

bool Ldlt::factorize(const Sparse& upper, const RunContext& run) {
    rows_.resize(start_.back());
    values_.resize(start_.back());
    diagonal_.resize(size_);
    std::vector<std::size_t> end(start_.begin(), start_.end() - 1);
    std::vector<double> y(size_, 0);
    std::vector<int> seen(size_, -1);
    std::vector<int> path;
    std::vector<int> pattern(size_);  // of row k of L, from `top`, each column before its parent
    for (int k = 0; k < size_; ++k) {
        if (run.stopped()) return false;  // the last rows take 15 ms each
        int top = size_;
        seen[k] = k;
        for (Sparse::InnerIterator entry(upper, k); entry; ++entry) {
            auto i = static_cast<int>(entry.index());
            y[i] += entry.value();
            for (path.clear(); seen[i] != k; i = parent_[i]) {
                path.push_back(i);
                seen[i] = k;
            }
            for (; !path.empty(); path.pop_back()) pattern[--top] = path.back();
        }
        double pivot = y[k];
        y[k] = 0;
        for (; top < size_; ++top) {
            const int i = pattern[top];
            const double yi = y[i];
            y[i] = 0;
            for (std::size_t p = start_[i]; p < end[i]; ++p) y[rows_[p]] -= values_[p] * yi;
            const double factor = yi / diagonal_[i];
            pivot -= factor * yi;
            rows_[end[i]] = k;
            values_[end[i]++] = factor;
        }
        if (!(pivot > 0)) return false;
        diagonal_[k] = pivot;
    }
    return true;
}

Eigen::VectorXd Ldlt::solve(Eigen::VectorXd b) const {
    for (int i = 0; i < size_; ++i)
        for (std::size_t p = start_[i]; p < start_[i + 1]; ++p) b[rows_[p]] -= values_[p] * b[i];
    for (int i = 0; i < size_; ++i) b[i] /= diagonal_[i];
    for (int i = size_; i-- > 0;)
        for (std::size_t p = start_[i]; p < start_[i + 1]; ++p) b[i] -= values_[p] * b[rows_[p]];
    return b;
}

}  // namespace rivage::core
