#include "core/solve/cholesky.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <vector>

#include "core/solve/ldlt.h"

namespace rivage::core {
namespace {

using Sparse = Ldlt::Sparse;

/// The pointels that share a square of the energy with each pointel, itself among them, ascending.
using Couplings = IdVector<PointelId, std::vector<PointelId>>;

Couplings listCouplings(const Energy& energy, const RunContext& run) {
    constexpr std::size_t kPoll = 1024;
    Couplings couplings(energy.size());
    std::size_t squares = 0;
    bool stopped = false;
    energy.forEachSquare([&](std::span<const Energy::Coefficient> row, const Mat3d&) {
        if (++squares % kPoll == 0) stopped = stopped || run.stopped();
        if (stopped) return;
        for (const auto& i : row)
            for (const auto& j : row) couplings[i.pointel].push_back(j.pointel);
    });
    serialFor(energy.size(), run, [&](std::size_t i) {
        auto& others = couplings.raw()[i];
        std::sort(others.begin(), others.end());
        others.erase(std::unique(others.begin(), others.end()), others.end());
    });
    return couplings;
}

/// An order of the pointels in which the factor stays sparse: of the pointels and not of their
/// coordinates, as it cannot be stopped and takes a tenth of the time so.
std::vector<PointelId> eliminationOrder(const Couplings& couplings) {
    std::vector<Eigen::Triplet<char, int>> entries;
    for (std::size_t i = 0; i < couplings.size(); ++i)
        for (const PointelId j : couplings.raw()[i])
            entries.emplace_back(static_cast<int>(i), static_cast<int>(index(j)), 1);
    const auto size = static_cast<int>(couplings.size());
    Eigen::SparseMatrix<char, Eigen::ColMajor, int> pattern(size, size);
    pattern.setFromTriplets(entries.begin(), entries.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>()(pattern, order);
    std::vector<PointelId> pointels;
    for (int k = 0; k < size; ++k)
        pointels.push_back(PointelId{static_cast<std::uint32_t>(order.indices()[k])});
    return pointels;
}

/// The upper triangle of H in elimination order, in blocks of 3x3.
class BlockMatrix {
public:
    BlockMatrix(const Couplings& couplings, const std::vector<PointelId>& order,
                const RunContext& run)
        : run_(run), order_(order), rank_(order.size()), columns_(order.size()) {
        for (std::uint32_t k = 0; k < order.size(); ++k) rank_[order[k]] = k;
        serialFor(order.size(), run, [&](std::size_t k) {
            for (const PointelId i : couplings[order[k]])
                if (rank_[i] <= k) columns_[k].ranks.push_back(rank_[i]);
            std::sort(columns_[k].ranks.begin(), columns_[k].ranks.end());
            columns_[k].blocks.assign(columns_[k].ranks.size(), Mat3d::Zero());
        });
    }

    void fill(const Energy& energy) {
        constexpr std::size_t kPoll = 1024;
        std::size_t squares = 0;
        bool stopped = run_.stopped();
        energy.forEachSquare([&](std::span<const Energy::Coefficient> row, const Mat3d& block) {
            if (++squares % kPoll == 0) stopped = stopped || run_.stopped();
            if (stopped) return;
            for (const auto& i : row)
                for (const auto& j : row)
                    if (rank_[i.pointel] <= rank_[j.pointel])
                        at(rank_[i.pointel], rank_[j.pointel]) += i.value * j.value * block;
        });
    }

    /// As a sparse matrix of coordinates; rows of those that cannot move are of the unit matrix.
    [[nodiscard]] Sparse sparse(const Boxes& boxes) const {
        const auto size = static_cast<Eigen::Index>(3 * columns_.size());
        std::size_t entries = 0;
        for (const Column& column : columns_) entries += 9 * column.blocks.size();
        Sparse matrix(size, size);
        matrix.reserve(static_cast<Eigen::Index>(entries));
        serialFor(columns_.size(), run_, [&](std::size_t k) { addColumns(k, boxes, matrix); });
        matrix.finalize();
        return matrix;
    }

private:
    struct Column {
        std::vector<std::uint32_t> ranks;  // ascending, the last is the column's own
        std::vector<Mat3d> blocks;
    };

    [[nodiscard]] Mat3d& at(std::uint32_t row, std::uint32_t column) {
        Column& in = columns_[column];
        const auto found = std::lower_bound(in.ranks.begin(), in.ranks.end(), row);
        return in.blocks[static_cast<std::size_t>(found - in.ranks.begin())];
    }

    void addColumns(std::size_t k, const Boxes& boxes, Sparse& matrix) const {
        const Column& column = columns_[k];
        const Box box = boxes[order_[k]];
        for (int c = 0; c < 3; ++c) {
            const auto at = static_cast<Eigen::Index>(3 * k) + c;
            matrix.startVec(at);
            for (std::size_t b = 0; b < column.ranks.size(); ++b) {
                const Box rowBox = boxes[order_[column.ranks[b]]];
                for (int r = 0; r < 3; ++r) {
                    const auto row = static_cast<Eigen::Index>(3 * column.ranks[b]) + r;
                    if (row > at) continue;
                    const bool moves = box.movable(c) && rowBox.movable(r);
                    const double held = row == at ? 1 : 0;
                    matrix.insertBack(row, at) = moves ? column.blocks[b](r, c) : held;
                }
            }
        }
    }

    const RunContext& run_;
    const std::vector<PointelId>& order_;
    IdVector<PointelId, std::uint32_t> rank_;  // in the order
    std::vector<Column> columns_;
};

}  // namespace

Result<Solution> solveCholesky(DisplacementSystem& system, const Boxes& boxes,
                               const RunContext& run) {
    const Energy& energy = system.energy();
    const Couplings couplings = listCouplings(energy, run);
    if (run.stopped()) return fail(run.stopError());
    const std::vector<PointelId> order = eliminationOrder(couplings);
    BlockMatrix blocks(couplings, order, run);
    blocks.fill(energy);
    if (run.stopped()) return fail(run.stopError());
    const Sparse matrix = blocks.sparse(boxes);
    if (run.stopped()) return fail(run.stopError());
    const Ldlt factor(matrix, run);
    if (run.stopped()) return fail(run.stopError());
    if (!factor.complete())
        return fail(ErrorCode::internal, "the Cholesky factorization broke down");

    Eigen::VectorXd right(static_cast<Eigen::Index>(3 * order.size()));
    for (std::size_t k = 0; k < order.size(); ++k) {
        const Box box = boxes[order[k]];
        for (int c = 0; c < 3; ++c)
            right[static_cast<Eigen::Index>(3 * k) + c] =
                box.movable(c) ? system.rightSide()[order[k]][c] : 0;
    }
    const Eigen::VectorXd solved = factor.solve(std::move(right));
    PointelVectors x = energy.restPositions();
    for (std::size_t k = 0; k < order.size(); ++k)
        x[order[k]] += solved.segment<3>(static_cast<Eigen::Index>(3 * k));
    Refinement refinement(system, boxes, &x);
    const double residual = refinement.measure();
    const double relative = refinement.initial() > 0 ? residual / refinement.initial() : 0;
    return Solution{refinement.positions(), "cholesky", 1, relative, true};
}

}  // namespace rivage::core
