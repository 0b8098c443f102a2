#include "core/solve/float_cg.h"

#include "core/solve/float_sums.h"

namespace rivage::core {

FloatCg::FloatCg(const Energy& energy, FloatOperator& operation, Preconditioner& preconditioner)
    : workers_(energy.workers()),
      operation_(operation),
      preconditioner_(preconditioner),
      e_(energy.size()),
      r_(energy.size()),
      p_(energy.size(), Float4{}),
      q_(energy.size()) {}

void FloatCg::setResidual(const FloatVectors& r) {
    r_ = r;
    e_ = FloatVectors(r.size(), Float4{});
}

double FloatCg::step() {
    const std::size_t size = r_.size();
    const double rz = preconditioner_.apply(r_);
    const float keep = rz_ > 0 ? static_cast<float>(rz / rz_) : 0;
    rz_ = rz;
    forEachLanes(size, workers_, [&](std::size_t i) {
        p_.raw()[i].lanes = preconditioner_.result(i) + keep * p_.raw()[i].lanes;
    });
    operation_.apply(p_, q_);
    const double curvature = sumLanes(
        size, workers_, [&](std::size_t i) { return p_.raw()[i].lanes * q_.raw()[i].lanes; });
    if (!(rz > 0 && curvature > 0)) return -1;
    const auto length = static_cast<float>(rz / curvature);
    const FloatVectors& free = preconditioner_.free();
    return sumLanes(size, workers_, [&](std::size_t i) {
        e_.raw()[i].lanes += length * p_.raw()[i].lanes;
        const Lanes r = r_.raw()[i].lanes - length * q_.raw()[i].lanes * free.raw()[i].lanes;
        r_.raw()[i].lanes = r;
        return r * r;
    });
}

}  // namespace rivage::core
