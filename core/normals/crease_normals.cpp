#include "core/normals/crease_normals.h"

#include "core/normals/blend.h"
#include "core/normals/disc_vote.h"
#include "core/normals/grow.h"
#include "core/normals/joint_bilateral.h"
#include "core/normals/smooth_normals.h"
#include "core/normals/surfel_loop.h"

namespace rivage::core {
namespace {

constexpr double kVoteRadius = 6;
constexpr int kVoteLinks = 9;     // links within which the voters of a surfel lie
constexpr double kBent = 1.2;     // flatness from which a disc may cross a crease
constexpr double kCreased = 1.7;  // flatness from which it does
// Creases lie between planar parts: where no such disc is near, high flatness is curvature.
constexpr double kPlanarRadius = 4;
constexpr double kPlanarSpread = 0.07;  // of votes, radians: below it the sides are planar
constexpr double kCurvedSpread = 0.15;  // above it they are curved
constexpr double kChosen = 0.5;         // shares of the time
constexpr double kVoted = 0.9;
constexpr BilateralWindow kCurvedSide{.radius = 5, .angle = 0.5};

}  // namespace

Result<CreaseNormals> creaseNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                    const IdVector<SurfelId, float>& bent, const RunContext& run) {
    const std::size_t count = surface.surfelCount();
    CreaseNormals creases{IdVector<SurfelId, float>(count, 0), NormalField(count)};
    IdVector<SurfelId, std::uint8_t> voters(count);
    for (std::size_t i = 0; i < count; ++i) voters.raw()[i] = bent.raw()[i] > kBent;
    voters = dilate(links, std::move(voters), kVoteLinks, run);

    DiscVoting voting(surface, kVoteRadius);
    IdVector<SurfelId, float> spread(count);
    NormalField guide(count);
    const auto choose = [&](SurfelId s, PatchWalker& walker) {
        guide[s] = surface.trivialNormal(s).cast<double>();
        if (voters[s]) voting.choose(s, walker);
    };
    const auto vote = [&](SurfelId s, PatchWalker& walker) {
        if (bent[s] <= kBent) return;
        const DiscVote result = voting.vote(s, walker);
        guide[s] = result.normal;
        spread[s] = static_cast<float>(result.spread);
        // Next to thin parts windows of any size mix their sides; small discs do so the least.
        if (result.planeRadius >= kPlanarRadius || bent[s] >= kFold)
            creases.share[s] = static_cast<float>(smoothstep(kBent, kCreased, bent[s]));
    };
    const auto refine = [&](SurfelId s, PatchWalker& walker) {
        creases.normals[s] = guide[s];
        const double curved = smoothstep(kPlanarSpread, kCurvedSpread, spread[s]);
        if (creases.share[s] == 0 || curved == 0) return;
        creases.normals[s] =
            blend(guide[s], bilateralNormal(surface, guide, walker, s, kCurvedSide), curved);
    };
    const bool done = forEachSurfel(surface, links, run.part(0, kChosen), choose) &&
                      forEachSurfel(surface, links, run.part(kChosen, kVoted), vote) &&
                      forEachSurfel(surface, links, run.part(kVoted, 1), refine);
    if (!done) return fail(run.stopError());
    return creases;
}

}  // namespace rivage::core
