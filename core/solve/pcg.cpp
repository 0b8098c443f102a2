#include "core/solve/pcg.h"

#include <Eigen/LU>

#include "core/solve/coarse_levels.h"

namespace rivage::core {

Solution solvePcg(DisplacementSystem& system, const SolveOptions& options, const RunContext& run) {
    IdVector<PointelId, Mat3d> inverse = system.energy().diagonalBlocks();
    system.forEach([&](PointelId i) { inverse[i] = inverse[i].inverse().eval(); });

    PointelVectors d(system.size(), Vec3d::Zero());
    PointelVectors r = system.rightSide();
    CoarseLevels coarse(system.energy());
    PointelVectors z(system.size());
    system.forEach([&](PointelId i) { z[i] = inverse[i] * r[i]; });
    coarse.add(r, z);
    PointelVectors p = z;
    PointelVectors q(system.size());

    Convergence convergence(system.norm(r), options, run);
    double rz = system.dot(r, z);
    int iterations = 0;
    while (convergence.goOn(system.norm(r), iterations)) {
        ++iterations;
        system.apply(p, q);
        const double step = rz / system.dot(p, q);
        system.forEach([&](PointelId i) {
            d[i] += step * p[i];
            r[i] -= step * q[i];
            z[i] = inverse[i] * r[i];
        });
        coarse.add(r, z);
        const double rzNext = system.dot(r, z);
        const double keep = rzNext / rz;
        rz = rzNext;
        system.forEach([&](PointelId i) { p[i] = z[i] + keep * p[i]; });
    }
    return {system.positions(d), "pcg", iterations, convergence.relative(), convergence.reached()};
}

}  // namespace rivage::core
