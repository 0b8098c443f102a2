#include "core/solve/local.h"

#include <algorithm>
#include <cmath>

#include "core/solve/box.h"

namespace rivage::core {
namespace {

/// Rings of pointels around a part whose weights and normals its own rows need: the tangential
/// fairness of a neighbour sees surfels that reach two linels further.
constexpr int kRings = 3;

/// 1 for the pointels within `reach` of the nearest changed one that they hang together with.
IdVector<PointelId, std::uint8_t> findPart(const DigitalSurface& surface,
                                           std::span<const PointelId> changed, double reach) {
    IdVector<PointelId, std::uint8_t> part(surface.pointelCount(), 0);
    std::vector<std::pair<PointelId, PointelId>> queue;  // a pointel and where it was reached from
    for (const PointelId p : changed) {
        if (part[p] == 0) queue.emplace_back(p, p);
        part[p] = 1;
    }
    for (std::size_t at = 0; at < queue.size(); ++at) {
        const auto [here, source] = queue[at];
        for (const PointelId next : surface.neighbours[here]) {
            if (next == kNone<PointelId> || part[next] != 0) continue;
            if ((surface.position(next) - surface.position(source)).norm() > reach) continue;
            part[next] = 1;
            queue.emplace_back(next, source);
        }
    }
    return part;
}

/// A part and the rings around it as a surface of its own, as far as the energy reads surfaces.
struct SubProblem {
    std::vector<PointelId> original;  // of each of its pointels
    DigitalSurface surface;
    NormalField normals;
    EnergyWeights weights;
    IdVector<PointelId, std::uint8_t> held;  // the rings
    PointelVectors start;
};

std::vector<PointelId> withRings(const DigitalSurface& surface,
                                 const IdVector<PointelId, std::uint8_t>& part) {
    IdVector<PointelId, std::uint8_t> seen = part;
    std::vector<PointelId> all;
    for (std::uint32_t i = 0; i < part.size(); ++i)
        if (part[PointelId{i}] != 0) all.push_back(PointelId{i});
    std::size_t begin = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        const std::size_t end = all.size();
        for (; begin < end; ++begin)
            for (const PointelId next : surface.neighbours[all[begin]]) {
                if (next == kNone<PointelId> || seen[next] != 0) continue;
                seen[next] = 1;
                all.push_back(next);
            }
    }
    std::sort(all.begin(), all.end());
    return all;
}

void copySurfels(const Energy& energy, const IdVector<PointelId, PointelId>& renamed,
                 SubProblem& sub) {
    const DigitalSurface& surface = energy.surface();
    for (std::uint32_t f = 0; f < surface.surfelCount(); ++f) {
        std::array<PointelId, 4> corners = surface.corners[SurfelId{f}];
        for (PointelId& corner : corners) corner = renamed[corner];
        if (std::find(corners.begin(), corners.end(), kNone<PointelId>) != corners.end()) continue;
        sub.surface.corners.push_back(corners);
        sub.normals.push_back(energy.normals()[SurfelId{f}]);
        sub.weights.beta.push_back(energy.weights().beta[SurfelId{f}]);
    }
}

SubProblem cutOut(const Energy& energy, const IdVector<PointelId, std::uint8_t>& part,
                  const PointelVectors& previous) {
    const DigitalSurface& surface = energy.surface();
    SubProblem sub;
    sub.original = withRings(surface, part);
    sub.surface.spacing = surface.spacing;
    IdVector<PointelId, PointelId> renamed(surface.pointelCount(), kNone<PointelId>);
    for (std::uint32_t i = 0; i < sub.original.size(); ++i) renamed[sub.original[i]] = PointelId{i};
    for (const PointelId p : sub.original) {
        auto neighbours = surface.neighbours[p];
        for (PointelId& next : neighbours)
            if (next != kNone<PointelId>) next = renamed[next];
        sub.surface.pointels.push_back(surface.pointels[p]);
        sub.surface.neighbours.push_back(neighbours);
        sub.surface.junctionSlots.push_back(surface.junctionSlots[p]);
        if (!surface.fixedAxes.empty()) sub.surface.fixedAxes.push_back(surface.fixedAxes[p]);
        sub.weights.alpha.push_back(energy.weights().alpha[p]);
        sub.weights.gamma.push_back(energy.weights().gamma[p]);
        sub.held.push_back(part[p] == 0 ? 1 : 0);
        sub.start.push_back(previous[p]);
    }
    copySurfels(energy, renamed, sub);
    return sub;
}

/// |projected gradient| of the pointels in the rings around the part.
double rimResidual(const Energy& energy, const SubProblem& sub, const Boxes& boxes,
                   const PointelVectors& positions) {
    const PointelVectors gradient = energy.gradient(positions);
    double squares = 0;
    for (std::uint32_t i = 0; i < sub.original.size(); ++i) {
        if (sub.held[PointelId{i}] == 0) continue;
        const PointelId p = sub.original[i];
        const Vec3d d = boxes[p].recover(positions[p], energy.restPosition(p));
        squares += boxes[p].projectedGradient(d, gradient[p]).squaredNorm();
    }
    return std::sqrt(squares);
}

double decayReach(const Energy& energy) {
    // An edit falls off by e every sqrt(2 beta / alpha) voxels, as two surfels share a linel; so
    // this leaves a thousandth of it.
    constexpr double kDecayLengths = 10;
    const auto& beta = energy.weights().beta.raw();
    const auto& alpha = energy.weights().alpha.raw();
    if (beta.empty()) return 0;
    return kDecayLengths * std::sqrt(*std::max_element(beta.begin(), beta.end()) /
                                     *std::min_element(alpha.begin(), alpha.end()));
}

}  // namespace

Result<LocalSolution> reminimizeAround(const Energy& energy, const PointelVectors& previous,
                                       std::span<const PointelId> changed,
                                       const SolveOptions& options, const RunContext& run) {
    const auto part = findPart(energy.surface(), changed, decayReach(energy));
    const SubProblem sub = cutOut(energy, part, previous);
    if (run.stopped()) return fail(run.stopError());
    const Energy subEnergy(sub.surface, sub.normals, sub.weights, energy.options(),
                           energy.workers());
    const auto solution =
        minimize(subEnergy, options, run, {.positions = &sub.start, .held = &sub.held});
    if (!solution) return fail(solution.error());

    LocalSolution local{.positions = previous,
                        .iterations = solution->iterations,
                        .converged = solution->converged};
    for (std::uint32_t i = 0; i < sub.original.size(); ++i) {
        if (sub.held[PointelId{i}] != 0) continue;
        local.positions[sub.original[i]] = solution->positions[PointelId{i}];
        ++local.touched;
    }
    const Boxes boxes(energy.surface(), options.displacementLimit);
    const PointelVectors atRest = energy.gradient(energy.restPositions());
    double squares = 0;
    for (std::uint32_t i = 0; i < energy.size(); ++i)
        squares += boxes[PointelId{i}]
                       .projectedGradient(Vec3d::Zero(), atRest[PointelId{i}])
                       .squaredNorm();
    if (squares > 0)
        local.rimResidual = rimResidual(energy, sub, boxes, local.positions) / std::sqrt(squares);
    return local;
}

}  // namespace rivage::core
