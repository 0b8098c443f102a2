#include "core/normals/disc_vote.h"

#include <algorithm>
#include <cmath>

namespace rivage::core {
namespace {

// Just above 1, so that the smallest disc has the four linked surfels.
constexpr double kSmallest = 1.01;
constexpr double kRadiusSteps[] = {kSmallest, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 6};
constexpr double kFlatEnough = 1.5;   // flatness at which a disc has no vote
constexpr double kNeverFlat = 4;      // flatness above which no larger disc is flat again
constexpr double kFirstWindow = 0.4;  // radians, of the mean shift
constexpr double kNarrowing = 0.6;
constexpr int kShifts = 6;

}  // namespace

DiscVoting::DiscVoting(const DigitalSurface& surface, double largest)
    : surface_(surface), best_(surface.surfelCount()) {
    for (const double radius : kRadiusSteps)
        if (radius < largest) radii_.push_back(radius);
    while (radii_.size() > 1 && radii_.back() + 2 <= largest) radii_.push_back(radii_.back() + 1);
    radii_.push_back(std::max(largest, kSmallest));
}

void DiscVoting::choose(SurfelId s, PatchWalker& walker) {
    const Vec3d trivial = surface_.trivialNormal(s).cast<double>();
    best_[s] = {trivial, radii_.front(), 1};
    walkDiscs(surface_, walker, s, radii_, [&](std::size_t scale, const Disc& disc) {
        consider(s, radii_[scale], disc);
        return disc.flatness < kNeverFlat;
    });
}

DiscVote DiscVoting::vote(SurfelId s, PatchWalker& walker) const {
    std::vector<Ballot> ballots;
    double planeRadius = 0;
    walker.walk(s, radii_.back(), [&](SurfelId g, const Vec3d&, double distance) {
        const PlaneDisc& disc = best_[g];
        if (distance >= disc.radius) return;
        ballots.push_back({disc.normal, weight(g, s, distance)});
        planeRadius = std::max(planeRadius, disc.radius);
    });
    DiscVote vote = count(ballots, surface_.trivialNormal(s).cast<double>());
    vote.planeRadius = planeRadius;
    return vote;
}

void DiscVoting::consider(SurfelId s, double radius, const Disc& disc) {
    if (!disc.coherent()) return;
    const double flat = std::max(0.0, 1 - disc.flatness / kFlatEnough);
    const double cube = flat * flat * flat;
    const double score = radius * radius * radius * cube * cube;
    if (score > best_[s].score) best_[s] = {disc.normal, radius, score};
}

double DiscVoting::weight(SurfelId voter, SurfelId s, double distance) const {
    const PlaneDisc& disc = best_[voter];
    // A plane has the fewer surfels of an axis, the less it faces that way.
    constexpr double kLeastFacing = 1e-3;
    const double facing = disc.normal[surface_.axis[s]] * (surface_.innerIsLow[s] ? 1 : -1);
    return disc.score * (1 - distance / disc.radius) * std::max(facing, kLeastFacing);
}

DiscVote DiscVoting::count(const std::vector<Ballot>& ballots, const Vec3d& fallback) {
    const auto meanOf = [&](auto&& weigh, const Vec3d& otherwise) {
        Vec3d sum = Vec3d::Zero();
        for (const Ballot& ballot : ballots) sum += weigh(ballot) * ballot.normal;
        constexpr double kCancelled = 1e-12;
        return sum.norm() > kCancelled ? Vec3d(sum.normalized()) : otherwise;
    };
    DiscVote vote;
    vote.normal = meanOf([](const Ballot& ballot) { return ballot.weight; }, fallback);
    double squares = 0;
    double weights = 0;
    for (const Ballot& ballot : ballots) {
        const double squared = (ballot.normal - vote.normal).squaredNorm();
        if (squared > kFirstWindow * kFirstWindow) continue;  // of another side
        squares += ballot.weight * squared;
        weights += ballot.weight;
    }
    vote.spread = weights > 0 ? std::sqrt(squares / weights) : kFirstWindow;
    double window = kFirstWindow;
    for (int shift = 0; shift < kShifts; ++shift, window *= kNarrowing) {
        const Vec3d centre = vote.normal;
        vote.normal = meanOf(
            [&](const Ballot& ballot) {
                constexpr double kNegligible = 12;  // e^-12
                const double power = (ballot.normal - centre).squaredNorm() / (window * window);
                return power < kNegligible ? ballot.weight * std::exp(-power) : 0;
            },
            centre);
    }
    return vote;
}

}  // namespace rivage::core
