#include "core/solve/refinement.h"

namespace rivage::core {
namespace {

float roundedDown(double v) {
    const auto f = static_cast<float>(v);
    return f > v ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

}  // namespace

Refinement::Refinement(DisplacementSystem& system, const Boxes& boxes, const PointelVectors* start)
    : system_(system), boxes_(boxes), d_(system.size(), Vec3d::Zero()), g_(system.size()) {
    initial_ = std::sqrt(system.sum(0.0, [&](PointelId i) {
        const Vec3d down = -system.rightSide()[i];
        return boxes_[i].projectedGradient(Vec3d::Zero(), down).squaredNorm();
    }));
    if (start == nullptr) return;
    const Energy& energy = system.energy();
    system.forEach(
        [&](PointelId i) { d_[i] = boxes_[i].recover((*start)[i], energy.restPosition(i)); });
    // A part that rests at its minimum may still be pulled by what is held beside it.
    if (boxes.holds()) initial_ = std::max(initial_, measure());
}

double Refinement::measure() {
    system_.gradient(d_, g_);
    return std::sqrt(system_.sum(
        0.0, [&](PointelId i) { return boxes_[i].projectedGradient(d_[i], g_[i]).squaredNorm(); }));
}

void Refinement::gradient(FloatVectors& g) const {
    g.resize(d_.size());
    system_.forEach([&](PointelId i) { g[i].lanes = lanesOf(g_[i]); });
}

void Refinement::residual(FloatVectors& r) const {
    r.resize(d_.size());
    system_.forEach(
        [&](PointelId i) { r[i].lanes = lanesOf(-boxes_[i].projectedGradient(d_[i], g_[i])); });
}

void Refinement::movable(FloatVectors& free) const {
    free.resize(d_.size());
    system_.forEach([&](PointelId i) {
        const Box box = boxes_[i];
        free[i].lanes =
            lanesOf(Vec3d(box.movable(0) ? 1 : 0, box.movable(1) ? 1 : 0, box.movable(2) ? 1 : 0));
    });
}

void Refinement::room(FloatVectors& lo, FloatVectors& hi) const {
    lo.resize(d_.size());
    hi.resize(d_.size());
    system_.forEach([&](PointelId i) {
        const Box box = boxes_[i];
        lo[i].lanes = hi[i].lanes = Lanes{};
        for (int k = 0; k < 3; ++k) {
            if (!box.movable(k)) continue;
            lo[i].lanes[k] = -roundedDown(d_[i][k] - box.low[k]);
            hi[i].lanes[k] = roundedDown(box.high[k] - d_[i][k]);
        }
    });
}

void Refinement::descend(const IdVector<PointelId, double>& m) {
    system_.forEach([&](PointelId i) {
        const Box box = boxes_[i];
        d_[i] = box.project(d_[i] - box.projectedGradient(d_[i], g_[i]) / m[i]);
    });
}

void Refinement::add(const FloatVectors& correction) {
    system_.forEach([&](PointelId i) {
        const Box box = boxes_[i];
        for (int k = 0; k < 3; ++k) {
            if (!box.movable(k)) continue;
            const float e = correction[i].lanes[k];
            const double moved = d_[i][k] + static_cast<double>(e);
            // A side as float arithmetic saw it is the side.
            const bool high = e >= roundedDown(box.high[k] - d_[i][k]);
            const bool low = e <= -roundedDown(d_[i][k] - box.low[k]);
            d_[i][k] = high ? box.high[k] : low ? box.low[k] : moved;
        }
    });
}

PointelVectors Refinement::positionsWith(const FloatVectors& correction) const {
    Refinement copy = *this;
    copy.add(correction);
    return copy.positions();
}

}  // namespace rivage::core
