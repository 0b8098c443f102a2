#include "core/solve/cholesky.h"

#include <Eigen/SparseCholesky>
#include <vector>

namespace rivage::core {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

Sparse assembleMatrix(const Energy& energy) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](const Energy::Coefficient& i, const Energy::Coefficient& j,
                         const Mat3d& block) {
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                entries.emplace_back(static_cast<int>(3 * index(i.pointel) + r),
                                     static_cast<int>(3 * index(j.pointel) + c),
                                     i.value * j.value * block(r, c));
    };
    energy.forEachSquare([&](std::span<const Energy::Coefficient> row, const Mat3d& block) {
        for (const auto& i : row)
            for (const auto& j : row) add(i, j, block);
    });
    const auto size = static_cast<Eigen::Index>(3 * energy.size());
    Sparse matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

}  // namespace

Result<Solution> solveCholesky(DisplacementSystem& system, const RunContext& run) {
    const Eigen::SimplicialLDLT<Sparse> factor(assembleMatrix(system.energy()));
    if (run.stopped()) return fail(run.stopError());
    const auto size = static_cast<Eigen::Index>(3 * system.size());
    Eigen::VectorXd right(size);
    for (std::size_t i = 0; i < system.size(); ++i)
        right.segment<3>(static_cast<Eigen::Index>(3 * i)) = system.rightSide().raw()[i];
    const Eigen::VectorXd solved = factor.solve(right);
    if (factor.info() != Eigen::Success)
        return fail(ErrorCode::internal, "the Cholesky factorization broke down");

    PointelVectors d(system.size());
    for (std::size_t i = 0; i < system.size(); ++i)
        d.raw()[i] = solved.segment<3>(static_cast<Eigen::Index>(3 * i));
    PointelVectors residual(system.size());
    system.gradient(d, residual);
    const double initial = system.norm(system.rightSide());
    const double relative = initial > 0 ? system.norm(residual) / initial : 0;
    return Solution{system.positions(d), "cholesky", 1, relative, true};
}

}  // namespace rivage::core
