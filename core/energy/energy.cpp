#include "core/energy/energy.h"

#include <Eigen/LU>
#include <utility>

#include "core/base/parallel.h"
#include "core/surface/incident_corners.h"

namespace rivage::core {
namespace {

PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }
SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }
constexpr std::size_t kBlock = 2048;

}  // namespace

EnergyWeights EnergyWeights::uniform(const DigitalSurface& surface, const EnergyOptions& options) {
    return {IdVector<PointelId, double>(surface.pointelCount(), options.alpha),
            IdVector<SurfelId, double>(surface.surfelCount(), options.beta),
            IdVector<PointelId, double>(surface.pointelCount(), options.gamma)};
}

Energy::Energy(const DigitalSurface& surface, NormalField normals, EnergyWeights weights,
               const EnergyOptions& options, const Workers& workers, RestShape rest)
    : surface_(surface),
      normals_(std::move(normals)),
      weights_(std::move(weights)),
      options_(options),
      workers_(workers),
      rest_(std::move(rest)) {
    chooseFairnessNeighbours(options.junctionFairness);
    listIncidentCorners();
    if (options.fairness == Fairness::tangential) computeTangentialFairness();
}

// Neighbours there inside every face of the domain that `i` lies on: others would pull it along
// the face, as if the surface ended at a right angle.
bool Energy::sharesFaces(PointelId i, PointelId neighbour) const {
    if (neighbour == kNone<PointelId>) return false;
    if (surface_.fixedAxes.empty()) return true;
    return (surface_.fixedAxes[i] & ~surface_.fixedAxes[neighbour]) == 0;
}

void Energy::chooseFairnessNeighbours(JunctionFairness rule) {
    fairnessSlots_.resize(size());
    inverseDegree_.resize(size());
    const auto choose = [&](std::size_t n) {
        const PointelId i = pointel(n);
        unsigned slots = 0;
        for (int slot = 0; slot < kSlots; ++slot)
            if (sharesFaces(i, surface_.neighbours[i][slot])) slots |= 1U << slot;
        if (rule == JunctionFairness::curve && surface_.junctionSlots[i] != 0)
            slots &= surface_.isJunctionPointel(i) ? 0U : surface_.junctionSlots[i];
        fairnessSlots_[i] = static_cast<std::uint8_t>(slots);
        inverseDegree_[i] = slots == 0 ? 0 : 1.0 / __builtin_popcount(slots);
    };
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) choose(n);
    });
}

void Energy::listIncidentCorners() {
    IncidentCorners around = core::incidentCorners(surface_, workers_);
    start_ = std::move(around.start);
    incident_ = std::move(around.corners);
}

// With M the mean of n n^T over the surfels around a pointel, the eigenvalues of M tell along how
// many directions the surface bends there; a direction with eigenvalue l is damped by
// 1 / (1 + (l / tau)^2), which T = (I + (M / tau)^2)^-1 does without the eigenvectors.
void Energy::computeTangentialFairness() {
    constexpr double kTau = 0.06;  // METHOD.md 2.7
    tangential_.resize(size());
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            Mat3d mean = Mat3d::Zero();
            for (std::uint32_t e = start_[n]; e < start_[n + 1]; ++e) {
                const Vec3d& normal = normals_[surfel(incident_[e] / 4)];
                mean += normal * normal.transpose();
            }
            mean /= (start_[n + 1] - start_[n]) * kTau;
            const Mat3d damped = (Mat3d::Identity() + mean * mean).inverse();
            tangential_[pointel(n)] = damped * damped;
        }
    });
}

PointelVectors Energy::restPositions() const {
    PointelVectors rest(size());
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) rest[pointel(n)] = restPosition(pointel(n));
    });
    return rest;
}

// How much edge k of a face rises along a direction at rest.
double Energy::restRise(SurfelId s, std::size_t k, const Vec3d& normal) const {
    const auto& corners = surface_.corners[s];
    return (rest_.positions[corners[(k + 1) & 3U]] - rest_.positions[corners[k]]).dot(normal);
}

// The rest shape is at its minimum for its own normals, so only their change pulls, and targets.
Vec3d Energy::shapeForce(PointelId i) const {
    Vec3d force = weights_.alpha[i] * (rest_.targets[i] - rest_.positions[i]);
    for (const std::uint32_t corner : incidentCorners(i)) {
        const SurfelId s = surfel(corner / 4);
        const std::size_t k = corner & 3U;
        const Vec3d turned = normals_[s] - rest_.normals[s];
        const double pull = restRise(s, k, turned) - restRise(s, (k + 3) & 3U, turned);
        force += weights_.beta[s] * pull * normals_[s];
    }
    return force;
}

PointelVectors Energy::restForce() const {
    const PointelVectors rest = restPositions();
    PointelVectors force(size());
    Scratch scratch;
    if (!rest_.any()) apply(rest, force, scratch);
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const PointelId i = pointel(n);
            force[i] = rest_.any() ? shapeForce(i) : weights_.alpha[i] * rest[i] - force[i];
        }
    });
    return force;
}

Vec3d Energy::fromMean(const PointelVectors& x, PointelId i) const {
    Vec3d sum = Vec3d::Zero();
    for (int slot = 0; slot < kSlots; ++slot)
        if (isFairnessNeighbour(i, slot)) sum += x[surface_.neighbours[i][slot]];
    return x[i] - sum * inverseDegree_[i];
}

Mat3d Energy::fairnessBlock(PointelId i) const {
    if (inverseDegree_[i] == 0) return Mat3d::Zero();
    if (tangential_.empty()) return weights_.gamma[i] * Mat3d::Identity();
    return weights_.gamma[i] * tangential_[i];
}

Vec3d Energy::applyFairness(PointelId i, const Vec3d& y) const {
    return weights_.gamma[i] * (tangential_.empty() ? y : Vec3d(tangential_[i] * y));
}

Mat3d Energy::alignmentBlock(PointelId i) const {
    Mat3d sum = Mat3d::Zero();
    for (std::uint32_t e = start_[index(i)]; e < start_[index(i) + 1]; ++e) {
        const SurfelId s = surfel(incident_[e] / 4);
        sum += weights_.beta[s] * normals_[s] * normals_[s].transpose();
    }
    return 2 * sum;  // two edges of each surfel end at i
}

EnergyReport Energy::value(const PointelVectors& x) const {
    EnergyReport energy;
    energy.data = blockedSum(size(), workers_, 0.0, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t n = begin; n < end; ++n) {
            const PointelId i = pointel(n);
            const Vec3d target = rest_.any() ? rest_.targets[i] : surface_.position(i);
            sum += weights_.alpha[i] * (x[i] - target).squaredNorm();
        }
        return sum;
    });
    const auto alignment = [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t f = begin; f < end; ++f) {
            const SurfelId s = surfel(f);
            const auto& corners = surface_.corners[s];
            for (std::size_t k = 0; k < 4; ++k) {
                double off = (x[corners[(k + 1) % 4]] - x[corners[k]]).dot(normals_[s]);
                if (rest_.any()) off -= restRise(s, k, rest_.normals[s]);
                sum += weights_.beta[s] * off * off;
            }
        }
        return sum;
    };
    energy.alignment = blockedSum(surface_.surfelCount(), workers_, 0.0, alignment);
    energy.fairness = blockedSum(size(), workers_, 0.0, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t n = begin; n < end; ++n) {
            if (inverseDegree_[pointel(n)] == 0) continue;
            Vec3d y = fromMean(x, pointel(n));
            if (rest_.any()) y -= fromMean(rest_.positions, pointel(n));
            sum += y.dot(applyFairness(pointel(n), y));
        }
        return sum;
    });
    return energy;
}

// Three passes, each with one writer per element: per surfel the alignment at its corners, per
// pointel the fairness term u = G B x, then out = A x + (alignment at i) + B^T u.
void Energy::apply(const PointelVectors& x, PointelVectors& out, Scratch& scratch) const {
    scratch.faceTerms.resize(surface_.surfelCount() * 4);
    scratch.fairnessTerms.resize(size());
    out.resize(size());
    auto& terms = scratch.faceTerms;
    auto& fair = scratch.fairnessTerms;
    parallelBlocks(
        surface_.surfelCount(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f) {
                const auto& c = surface_.corners[surfel(f)];
                const Vec3d& normal = normals_[surfel(f)];
                const double h[4] = {x[c[0]].dot(normal), x[c[1]].dot(normal), x[c[2]].dot(normal),
                                     x[c[3]].dot(normal)};
                const double beta = weights_.beta[surfel(f)];
                for (int k = 0; k < 4; ++k)
                    terms[4 * f + k] = beta * (2 * h[k] - h[(k + 1) % 4] - h[(k + 3) % 4]);
            }
        });
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const PointelId i = pointel(n);
            fair[i] =
                inverseDegree_[i] == 0 ? Vec3d(Vec3d::Zero()) : applyFairness(i, fromMean(x, i));
        }
    });
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const PointelId i = pointel(n);
            Vec3d sum = weights_.alpha[i] * x[i] + fair[i];
            for (std::uint32_t e = start_[n]; e < start_[n + 1]; ++e)
                sum += normals_[surfel(incident_[e] / 4)] * terms[incident_[e]];
            for (int slot = 0; slot < kSlots; ++slot) {
                const PointelId j = surface_.neighbours[i][slot];
                if (j != kNone<PointelId> && isFairnessNeighbour(j, slot ^ 1))
                    sum -= fair[j] * inverseDegree_[j];
            }
            out[i] = sum;
        }
    });
}

PointelVectors Energy::gradient(const PointelVectors& x) const {
    PointelVectors result;
    Scratch scratch;
    PointelVectors moved = x;
    PointelVectors force;
    if (rest_.any()) {
        force = restForce();
        for (std::size_t n = 0; n < size(); ++n) moved[pointel(n)] -= rest_.positions[pointel(n)];
    }
    apply(moved, result, scratch);
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const PointelId i = pointel(n);
            const Vec3d pull =
                rest_.any() ? force[i] : Vec3d(weights_.alpha[i] * surface_.position(i));
            result[i] = 2 * (result[i] - pull);
        }
    });
    return result;
}

IdVector<PointelId, Mat3d> Energy::diagonalBlocks() const {
    IdVector<PointelId, Mat3d> blocks(size());
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const PointelId i = pointel(n);
            Mat3d block = weights_.alpha[i] * Mat3d::Identity() + alignmentBlock(i);
            block += fairnessBlock(i);
            for (int slot = 0; slot < kSlots; ++slot) {
                const PointelId j = surface_.neighbours[i][slot];
                if (j != kNone<PointelId> && isFairnessNeighbour(j, slot ^ 1))
                    block += fairnessBlock(j) * (inverseDegree_[j] * inverseDegree_[j]);
            }
            blocks[i] = block;
        }
    });
    return blocks;
}

IdVector<PointelId, double> Energy::majorizer() const {
    IdVector<PointelId, double> bound(size());
    parallelBlocks(size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const PointelId i = pointel(n);
            // The Frobenius norm: hardly more than the largest eigenvalue where one dominates.
            const double alignment = alignmentBlock(i).norm();
            double fairness = inverseDegree_[i] == 0 ? 0 : weights_.gamma[i];
            for (int slot = 0; slot < kSlots; ++slot) {
                const PointelId j = surface_.neighbours[i][slot];
                if (j != kNone<PointelId> && isFairnessNeighbour(j, slot ^ 1))
                    fairness += weights_.gamma[j] * inverseDegree_[j];
            }
            bound[i] = weights_.alpha[i] + 2 * alignment + 2 * fairness;
        }
    });
    return bound;
}

}  // namespace rivage::core
