#include "core/solve/float_mprgp.h"

#include <cmath>
#include <limits>

#include "core/solve/float_sums.h"

namespace rivage::core {
namespace {

// Of at most 2 / |M^-1 H|, and the metric M has |M^-1 H| <= 1 with a margin.
constexpr float kStep = 1.8F;

}  // namespace

FloatMprgp::FloatMprgp(const Energy& energy, FloatOperator& operation,
                       Preconditioner& preconditioner)
    : size_(energy.size()),
      workers_(energy.workers()),
      operation_(operation),
      preconditioner_(preconditioner),
      inverseMetric_(size_),
      e_(size_, Float4{}),
      g_(size_),
      p_(size_, Float4{}),
      q_(size_),
      work_(size_) {
    chooseMetric(energy);
}

// A diagonal M, as small as it may be with |M^-1 H| <= 1: the smaller, the longer the steps. Its
// shape mixes the row sums of the diagonal blocks with the safe bound of METHOD.md 2.2, which alone
// is the same in all directions; a few power iterations find its size.
void FloatMprgp::chooseMetric(const Energy& energy) {
    constexpr float kSafeShare = 0.3F;  // of 0, 0.1, 0.3, 1 the best on the sample island
    constexpr int kPowerSteps = 8;
    constexpr float kMargin = 1.15F;  // over what the power iterations have not yet found
    const IdVector<PointelId, double> safe = energy.majorizer();
    forEachLanes(size_, workers_, [&](std::size_t i) {
        const Symmetric3& block = preconditioner_.blocks().raw()[i];
        const Lanes beside = block.beside < 0 ? -block.beside : block.beside;
        const Lanes m = block.diagonal + beside + turnedTwice(beside) +
                        kSafeShare * static_cast<float>(safe.raw()[i]);
        inverseMetric_.raw()[i].lanes = Lanes{1, 1, 1, 0} / m;
        // Any start will do that has all directions in it: a hash of the pointel.
        const std::uint32_t hash = (static_cast<std::uint32_t>(i) + 1) * 2654435761U;
        const auto byte = [&](int shift) {
            return static_cast<float>(hash >> shift & 255U) - 127.5F;
        };
        p_.raw()[i].lanes = Lanes{byte(8), byte(16), byte(24), 0};
    });
    float largest = 0;
    for (int k = 0; k < kPowerSteps; ++k) {
        operation_.apply(p_, q_);
        // |M^-1/2 H M^-1/2| by the growth of p -> M^-1 H p in the norm of M.
        const double before = sumLanes(size_, workers_, [&](std::size_t i) {
            const Lanes p = p_.raw()[i].lanes;
            return p * p / (inverseMetric_.raw()[i].lanes + Lanes{0, 0, 0, 1});
        });
        const double after = sumLanes(size_, workers_, [&](std::size_t i) {
            const Lanes q = q_.raw()[i].lanes;
            return q * q * inverseMetric_.raw()[i].lanes;
        });
        if (!(before > 0 && after > 0)) break;
        largest = static_cast<float>(std::sqrt(after / before));
        const auto scale = static_cast<float>(1 / std::sqrt(after));
        forEachLanes(size_, workers_, [&](std::size_t i) {
            p_.raw()[i].lanes = scale * q_.raw()[i].lanes * inverseMetric_.raw()[i].lanes;
        });
    }
    const float scale = largest > 0 ? 1 / (kMargin * largest) : 1;
    forEachLanes(size_, workers_, [&](std::size_t i) { inverseMetric_.raw()[i].lanes *= scale; });

    // The data term alone bounds the eigenvalues of M^-1 H from below.
    float smallest = 1;
    for (std::size_t i = 0; i < size_; ++i) {
        const auto alpha = static_cast<float>(energy.weights().alpha.raw()[i]);
        const Lanes share = alpha * inverseMetric_.raw()[i].lanes;
        smallest = std::min({smallest, share[0], share[1], share[2]});
    }
    const double root = std::sqrt(smallest);
    mostMomentum_ = (1 - root) / (1 + root);
}

void FloatMprgp::start(const FloatVectors& lo, const FloatVectors& hi,
                       const FloatVectors& gradient) {
    lo_ = lo;
    hi_ = hi;
    startGradient_ = gradient;
    g_ = gradient;
    momentum_ = 1;
    forEachLanes(size_, workers_, [&](std::size_t i) {
        e_.raw()[i].lanes = Lanes{};
        p_.raw()[i].lanes = Lanes{};
    });
    judge();
}

Lanes FloatMprgp::clamped(std::size_t i, const Lanes& e) const {
    const Lanes hi = hi_.raw()[i].lanes;
    const Lanes lo = lo_.raw()[i].lanes;
    const Lanes below = e > hi ? hi : e;
    return below < lo ? lo : below;
}

Lanes FloatMprgp::freeGradient(std::size_t i) const {
    const Lanes e = e_.raw()[i].lanes;
    const auto free = (e < hi_.raw()[i].lanes) & (e > lo_.raw()[i].lanes);
    return free ? g_.raw()[i].lanes : Lanes{};
}

// Of the coordinates on a side that want to leave it; held ones are on both sides.
Lanes FloatMprgp::choppedGradient(std::size_t i) const {
    const Lanes e = e_.raw()[i].lanes;
    const Lanes g = g_.raw()[i].lanes;
    const auto high = e >= hi_.raw()[i].lanes;
    const auto low = e <= lo_.raw()[i].lanes;
    const auto leaves = (high & ~low & (g > 0)) | (low & ~high & (g < 0));
    return leaves ? g : Lanes{};
}

// The momentum grows as Nesterov's does, up to what the smallest eigenvalue allows, and sets the
// three factors of the triple momentum method, which needs half the steps of Nesterov's.
FloatMprgp::Momentum FloatMprgp::nextMomentum() {
    const double next = (1 + std::sqrt(1 + 4 * momentum_ * momentum_)) / 2;
    const double carry = std::min((momentum_ - 1) / next, mostMomentum_);
    momentum_ = next;
    const double rate = 2 * carry / (1 + carry);
    if (rate == 0) return {0, 0, 1};
    return {static_cast<float>(rate * rate / (2 - rate)),
            static_cast<float>(rate * rate / ((1 + rate) * (2 - rate))),
            static_cast<float>(1 + rate)};
}

void FloatMprgp::approachStep() {
    FloatVectors& last = p_;
    FloatVectors& ahead = work_;
    const Momentum momentum = nextMomentum();
    forEachLanes(size_, workers_, [&](std::size_t i) {
        const Lanes e = e_.raw()[i].lanes;
        ahead.raw()[i].lanes = e + momentum.look * (e - last.raw()[i].lanes);
    });
    operation_.apply(ahead, q_);
    forEachLanes(size_, workers_, [&](std::size_t i) {
        const Lanes e = e_.raw()[i].lanes;
        const Lanes gradient = q_.raw()[i].lanes + startGradient_.raw()[i].lanes;
        const Lanes down = momentum.step * inverseMetric_.raw()[i].lanes * gradient;
        e_.raw()[i].lanes = clamped(i, e + momentum.carry * (e - last.raw()[i].lanes) - down);
        last.raw()[i].lanes = e;
    });
}

void FloatMprgp::measure() {
    momentum_ = 1;
    recomputeGradient();
    judge();
}

void FloatMprgp::recomputeGradient() {
    operation_.apply(e_, q_);
    forEachLanes(size_, workers_, [&](std::size_t i) {
        g_.raw()[i].lanes = q_.raw()[i].lanes + startGradient_.raw()[i].lanes;
    });
}

// The residual, and whether the free coordinates still have more to give than the chopped ones.
void FloatMprgp::judge() {
    struct Sums {
        double residual = 0, chopped = 0, reduced = 0;
        Sums operator+(const Sums& o) const {
            return {residual + o.residual, chopped + o.chopped, reduced + o.reduced};
        }
    };
    const auto add = [](double& sum, const Lanes& v) {
        sum += double{v[0]} + double{v[1]} + double{v[2]};
    };
    const Sums sums = blockedSum(
        size_, workers_, Sums{},
        [&](std::size_t begin, std::size_t end) {
            Sums block;
            for (std::size_t i = begin; i < end;) {
                Lanes residual{}, given{}, reduced{};
                for (const std::size_t stop = std::min(end, i + 16); i < stop; ++i) {
                    const Lanes free = freeGradient(i);
                    const Lanes chopped = choppedGradient(i);
                    const Lanes metric = inverseMetric_.raw()[i].lanes;
                    const Lanes e = e_.raw()[i].lanes;
                    const Lanes moved = e - clamped(i, e - kStep * metric * free);
                    residual += free * free + chopped * chopped;
                    given += chopped * chopped * metric;
                    reduced += moved * free;
                }
                add(block.residual, residual);
                add(block.chopped, given);
                add(block.reduced, reduced);
            }
            return block;
        },
        kFloatBlock);
    residual_ = sums.residual;
    proportional_ = sums.chopped <= sums.reduced / kStep;
}

// Begins conjugate gradients on the face of the box that e is on.
void FloatMprgp::restart() {
    FloatVectors& free = work_;
    forEachLanes(size_, workers_, [&](std::size_t i) {
        const Lanes e = e_.raw()[i].lanes;
        const Lanes one{1, 1, 1, 0};
        const auto inside = (e < hi_.raw()[i].lanes) & (e > lo_.raw()[i].lanes);
        free.raw()[i].lanes = inside ? one : Lanes{};
    });
    preconditioner_.setFree(free);
    forEachLanes(size_, workers_, [&](std::size_t i) {
        q_.raw()[i].lanes = g_.raw()[i].lanes * free.raw()[i].lanes;
    });
    rz_ = preconditioner_.apply(q_);
    forEachLanes(size_, workers_,
                 [&](std::size_t i) { p_.raw()[i].lanes = preconditioner_.result(i); });
}

struct FloatMprgp::Lengths {
    double curvature = 0, descent = 0;
    float feasible = std::numeric_limits<float>::infinity();
    Lengths operator+(const Lengths& o) const {
        return {curvature + o.curvature, descent + o.descent, std::min(feasible, o.feasible)};
    }
};

// p . H p, p . g, and the largest step against p that stays in the box.
FloatMprgp::Lengths FloatMprgp::lengthsAlong() const {
    return blockedSum(
        size_, workers_, Lengths{},
        [&](std::size_t begin, std::size_t end) {
            const Lanes unbounded = Lanes{} + std::numeric_limits<float>::infinity();
            Lengths block;
            Lanes nearest = unbounded;
            for (std::size_t i = begin; i < end;) {
                Lanes curvature{}, descent{};
                for (const std::size_t stop = std::min(end, i + 16); i < stop; ++i) {
                    const Lanes p = p_.raw()[i].lanes;
                    const Lanes e = e_.raw()[i].lanes;
                    curvature += p * q_.raw()[i].lanes;
                    descent += p * g_.raw()[i].lanes;
                    const Lanes room = e - (p > 0 ? lo_.raw()[i].lanes : hi_.raw()[i].lanes);
                    const Lanes length = p == 0 ? unbounded : room / p;
                    nearest = length < nearest ? length : nearest;
                }
                block.curvature +=
                    double{curvature[0]} + double{curvature[1]} + double{curvature[2]};
                block.descent += double{descent[0]} + double{descent[1]} + double{descent[2]};
            }
            block.feasible = std::min({nearest[0], nearest[1], nearest[2]});
            return block;
        },
        kFloatBlock);
}

int FloatMprgp::step() {
    const int applications = proportional_ ? conjugateStep() : proportioningStep();
    judge();
    return applications;
}

int FloatMprgp::conjugateStep() {
    operation_.apply(p_, q_);
    const Lengths lengths = lengthsAlong();
    if (!(lengths.curvature > 0 && lengths.descent > 0 && rz_ > 0)) return 0;
    const auto best = static_cast<float>(lengths.descent / lengths.curvature);
    if (best > lengths.feasible) return 1 + expand(best, lengths.feasible);
    const FloatVectors& free = preconditioner_.free();
    forEachLanes(size_, workers_, [&](std::size_t i) {
        e_.raw()[i].lanes = clamped(i, e_.raw()[i].lanes - best * p_.raw()[i].lanes);
        g_.raw()[i].lanes -= best * q_.raw()[i].lanes;
        work_.raw()[i].lanes = g_.raw()[i].lanes * free.raw()[i].lanes;
    });
    const double rz = preconditioner_.apply(work_);
    const auto keep = static_cast<float>(rz / rz_);
    rz_ = rz;
    forEachLanes(size_, workers_, [&](std::size_t i) {
        p_.raw()[i].lanes = preconditioner_.result(i) + keep * p_.raw()[i].lanes;
    });
    return 1;
}

// The energy less that at e = 0.
double FloatMprgp::energy() const {
    return sumLanes(size_, workers_, [&](std::size_t i) {
        return 0.5F * e_.raw()[i].lanes * (g_.raw()[i].lanes + startGradient_.raw()[i].lanes);
    });
}

// The step of the conjugate gradients, projected: it may reach many sides at once. Where that does
// not lower the energy, the step that always does: to the first side, then a projected gradient
// step.
int FloatMprgp::expand(float best, float feasible) {
    const double before = energy();
    FloatVectors& last = work_;
    forEachLanes(size_, workers_, [&](std::size_t i) {
        const Lanes e = e_.raw()[i].lanes;
        last.raw()[i].lanes = e;
        e_.raw()[i].lanes = clamped(i, e - best * p_.raw()[i].lanes);
    });
    recomputeGradient();
    int applications = 1;
    if (!(energy() < before)) {
        forEachLanes(size_, workers_, [&](std::size_t i) {
            e_.raw()[i].lanes = clamped(i, last.raw()[i].lanes - feasible * p_.raw()[i].lanes);
        });
        recomputeGradient();
        forEachLanes(size_, workers_, [&](std::size_t i) {
            const Lanes down = kStep * inverseMetric_.raw()[i].lanes * freeGradient(i);
            e_.raw()[i].lanes = clamped(i, e_.raw()[i].lanes - down);
        });
        recomputeGradient();
        applications = 3;
    }
    restart();
    return applications;
}

// Releases coordinates from their sides along the chopped gradient.
int FloatMprgp::proportioningStep() {
    forEachLanes(size_, workers_, [&](std::size_t i) {
        p_.raw()[i].lanes = inverseMetric_.raw()[i].lanes * choppedGradient(i);
    });
    operation_.apply(p_, q_);
    const Lengths lengths = lengthsAlong();
    if (!(lengths.curvature > 0 && lengths.descent > 0)) return 0;
    const auto best = static_cast<float>(lengths.descent / lengths.curvature);
    const float length = std::min(best, lengths.feasible);
    forEachLanes(size_, workers_, [&](std::size_t i) {
        e_.raw()[i].lanes = clamped(i, e_.raw()[i].lanes - length * p_.raw()[i].lanes);
        g_.raw()[i].lanes -= length * q_.raw()[i].lanes;
    });
    restart();
    return 1;
}

}  // namespace rivage::core
