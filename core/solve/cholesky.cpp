#include "core/solve/cholesky.h"

#include <Eigen/SparseCholesky>
#include <vector>

namespace rivage::core {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

Sparse assembleMatrix(const Energy& energy, const Boxes& boxes, const RunContext& run) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](const Energy::Coefficient& i, const Energy::Coefficient& j,
                         const Mat3d& block) {
        const Vec3d rows = boxes[i.pointel].limit;
        const Vec3d columns = boxes[j.pointel].limit;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                if (rows[r] > 0 && columns[c] > 0)
                    entries.emplace_back(static_cast<int>(3 * index(i.pointel) + r),
                                         static_cast<int>(3 * index(j.pointel) + c),
                                         i.value * j.value * block(r, c));
    };
    std::size_t squares = 0;
    bool stopped = false;
    energy.forEachSquare([&](std::span<const Energy::Coefficient> row, const Mat3d& block) {
        if (++squares % 1024 == 0) stopped = stopped || run.stopped();
        if (stopped) return;
        for (const auto& i : row)
            for (const auto& j : row) add(i, j, block);
    });
    for (std::uint32_t i = 0; i < energy.size(); ++i)
        for (int k = 0; k < 3; ++k)
            if (boxes[PointelId{i}].limit[k] == 0)
                entries.emplace_back(static_cast<int>(3 * i + k), static_cast<int>(3 * i + k), 1.0);
    const auto size = static_cast<Eigen::Index>(3 * energy.size());
    Sparse matrix(size, size);
    if (!stopped) matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

}  // namespace

Result<Solution> solveCholesky(DisplacementSystem& system, const Boxes& boxes,
                               const RunContext& run) {
    const Sparse matrix = assembleMatrix(system.energy(), boxes, run);
    if (run.stopped()) return fail(run.stopError());
    const Eigen::SimplicialLDLT<Sparse> factor(matrix);
    if (run.stopped()) return fail(run.stopError());
    const auto size = static_cast<Eigen::Index>(3 * system.size());
    Eigen::VectorXd right(size);
    for (std::uint32_t i = 0; i < system.size(); ++i) {
        const PointelId p{i};
        const Vec3d free = (boxes[p].limit.array() > 0).cast<double>();
        right.segment<3>(3 * static_cast<Eigen::Index>(i)) =
            system.rightSide()[p].cwiseProduct(free);
    }
    const Eigen::VectorXd solved = factor.solve(right);
    if (factor.info() != Eigen::Success)
        return fail(ErrorCode::internal, "the Cholesky factorization broke down");

    PointelVectors x = system.energy().restPositions();
    for (std::size_t i = 0; i < system.size(); ++i)
        x.raw()[i] += solved.segment<3>(static_cast<Eigen::Index>(3 * i));
    Refinement refinement(system, boxes, &x);
    const double residual = refinement.measure();
    const double relative = refinement.initial() > 0 ? residual / refinement.initial() : 0;
    return Solution{refinement.positions(), "cholesky", 1, relative, true};
}

}  // namespace rivage::core
