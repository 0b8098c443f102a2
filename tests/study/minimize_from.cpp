#include "tests/study/minimize_from.h"

#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace rivage::study {
namespace {

constexpr int kSteps = 5000;

double dot(const PointelVectors& a, const PointelVectors& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a.raw()[i].dot(b.raw()[i]);
    return sum;
}

/// The system H d = force of the displacement d = x - p.
struct System {
    const Energy& energy;
    PointelVectors force;
    Energy::Scratch scratch;

    System(const Energy& ofEnergy, const PointelVectors& rest) : energy(ofEnergy) {
        energy.apply(energy.restPositions(), force, scratch);
        for (std::uint32_t i = 0; i < force.size(); ++i) {
            const PointelId p{i};
            force[p] = energy.weights().alpha[p] * rest[p] - force[p];
        }
    }
};

void add(PointelVectors& x, double factor, const PointelVectors& y) {
    for (std::size_t i = 0; i < x.size(); ++i) x.raw()[i] += factor * y.raw()[i];
}

/// Conjugate gradients with the blocks on the diagonal as preconditioner.
PointelVectors solveFree(System& system, double tolerance) {
    IdVector<PointelId, Mat3d> blocks = system.energy.diagonalBlocks();
    for (Mat3d& block : blocks) block = block.inverse().eval();
    const auto preconditioned = [&](const PointelVectors& r) {
        PointelVectors z = r;
        for (std::size_t i = 0; i < z.size(); ++i) z.raw()[i] = blocks.raw()[i] * r.raw()[i];
        return z;
    };
    PointelVectors x(system.force.size(), Vec3d::Zero());
    PointelVectors residual = system.force;
    PointelVectors z = preconditioned(residual);
    PointelVectors direction = z;
    PointelVectors product;
    const double goal = tolerance * tolerance * dot(residual, residual);
    double slope = dot(residual, z);
    for (int k = 0; k < kSteps && dot(residual, residual) > goal; ++k) {
        system.energy.apply(direction, product, system.scratch);
        const double step = slope / dot(direction, product);
        add(x, step, direction);
        add(residual, -step, product);
        z = preconditioned(residual);
        const double next = dot(residual, z);
        for (std::size_t i = 0; i < z.size(); ++i)
            direction.raw()[i] = z.raw()[i] + next / slope * direction.raw()[i];
        slope = next;
    }
    return x;
}

/// A projected step from `from`; `moved` is scaled back to a gradient.
PointelVectors projectedStep(System& system, const IdVector<PointelId, double>& majorizer,
                             double limit, const PointelVectors& from, PointelVectors& moved) {
    PointelVectors to;
    system.energy.apply(from, to, system.scratch);
    moved.resize(from.size());
    for (std::uint32_t i = 0; i < from.size(); ++i) {
        const PointelId p{i};
        const Vec3d free = from[p] + (system.force[p] - to[p]) / majorizer[p];
        to[p] = free.cwiseMax(Vec3d::Constant(-limit)).cwiseMin(Vec3d::Constant(limit));
        moved[p] = majorizer[p] * (to[p] - from[p]);
    }
    return to;
}

/// Projected gradients with momentum, which ends where it leads uphill.
PointelVectors solveInBox(System& system, double limit, double tolerance) {
    const IdVector<PointelId, double> majorizer = system.energy.majorizer();
    PointelVectors x(system.force.size(), Vec3d::Zero());
    PointelVectors ahead = x;
    PointelVectors moved;
    double goal = 0;
    double t = 1;
    for (int k = 0; k < kSteps; ++k) {
        PointelVectors next = projectedStep(system, majorizer, limit, ahead, moved);
        const double size = dot(moved, moved);
        if (k == 0) goal = tolerance * tolerance * size;
        double along = 0;
        for (std::size_t i = 0; i < x.size(); ++i)
            along += moved.raw()[i].dot(next.raw()[i] - x.raw()[i]);
        const double nextT = along < 0 ? 1 : 0.5 * (1 + std::sqrt(1 + 4 * t * t));
        const double momentum = along < 0 ? 0 : (t - 1) / nextT;
        for (std::size_t i = 0; i < x.size(); ++i)
            ahead.raw()[i] = next.raw()[i] + momentum * (next.raw()[i] - x.raw()[i]);
        t = nextT;
        x = std::move(next);
        if (size <= goal) break;
    }
    return x;
}

}  // namespace

PointelVectors minimizeFrom(const Energy& energy, const PointelVectors& rest,
                            std::optional<double> limit) {
    System system(energy, rest);
    PointelVectors x = limit ? solveInBox(system, *limit, 1e-6) : solveFree(system, 1e-6);
    add(x, 1, energy.restPositions());
    return x;
}

}  // namespace rivage::study
