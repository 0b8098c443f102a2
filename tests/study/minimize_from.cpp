#include "tests/study/minimize_from.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rivage::study {
namespace {

double dot(const PointelVectors& a, const PointelVectors& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a.raw()[i].dot(b.raw()[i]);
    return sum;
}

/// The displacements d = x - p and what moves them.
class Descent {
public:
    Descent(const Energy& energy, const PointelVectors& rest, std::optional<double> limit)
        : energy_(energy), limit_(limit), majorizer_(energy.majorizer()) {
        // Half the gradient at displacement d is H d + H p - A rest = H d - force.
        const PointelVectors lattice = energy.restPositions();
        energy.apply(lattice, force_, scratch_);
        for (std::uint32_t i = 0; i < force_.size(); ++i) {
            const PointelId p{i};
            force_[p] = energy.weights().alpha[p] * rest[p] - force_[p];
        }
    }

    /// A projected step from `from`; `moved` is scaled back to a gradient.
    PointelVectors step(const PointelVectors& from, PointelVectors& moved) {
        energy_.apply(from, product_, scratch_);
        PointelVectors to = from;
        moved.resize(from.size());
        for (std::uint32_t i = 0; i < from.size(); ++i) {
            const PointelId p{i};
            to[p] = from[p] + (force_[p] - product_[p]) / majorizer_[p];
            if (limit_)
                to[p] =
                    to[p].cwiseMax(Vec3d::Constant(-*limit_)).cwiseMin(Vec3d::Constant(*limit_));
            moved[p] = majorizer_[p] * (to[p] - from[p]);
        }
        return to;
    }

private:
    const Energy& energy_;
    std::optional<double> limit_;
    IdVector<PointelId, double> majorizer_;
    PointelVectors force_;
    PointelVectors product_;
    Energy::Scratch scratch_;
};

}  // namespace

PointelVectors minimizeFrom(const Energy& energy, const PointelVectors& rest,
                            std::optional<double> limit) {
    constexpr int kSteps = 3000;
    constexpr double kTolerance = 1e-4;
    Descent descent(energy, rest, limit);
    PointelVectors x(energy.size(), Vec3d::Zero());
    PointelVectors ahead = x;
    PointelVectors moved;
    double first = 0;
    double t = 1;
    for (int k = 0; k < kSteps; ++k) {
        PointelVectors next = descent.step(ahead, moved);
        const double size = dot(moved, moved);
        if (k == 0) first = size;
        if (size <= kTolerance * kTolerance * first) {
            x = std::move(next);
            break;
        }
        double along = 0;  // of the step against the last move: uphill means too much momentum
        for (std::size_t i = 0; i < x.size(); ++i)
            along += moved.raw()[i].dot(next.raw()[i] - x.raw()[i]);
        const double nextT = along < 0 ? 1 : 0.5 * (1 + std::sqrt(1 + 4 * t * t));
        const double momentum = along < 0 ? 0 : (t - 1) / nextT;
        for (std::size_t i = 0; i < x.size(); ++i)
            ahead.raw()[i] = next.raw()[i] + momentum * (next.raw()[i] - x.raw()[i]);
        t = nextT;
        x = std::move(next);
    }
    const PointelVectors lattice = energy.restPositions();
    for (std::size_t i = 0; i < x.size(); ++i) x.raw()[i] += lattice.raw()[i];
    return x;
}

}  // namespace rivage::study
