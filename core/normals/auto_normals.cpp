#include "core/normals/auto_normals.h"

#include <algorithm>
#include <cmath>

#include "core/normals/blend.h"
#include "core/normals/crease_normals.h"
#include "core/normals/disc_vote.h"
#include "core/normals/grow.h"
#include "core/normals/noise_level.h"
#include "core/normals/robust.h"
#include "core/normals/sharp_edges.h"
#include "core/normals/smooth_normals.h"
#include "core/normals/surfel_loop.h"

namespace rivage::core {
namespace {

constexpr double kSmoothRadius = 5;  // best or near it on balls of radius 3.5 to 31
constexpr double kLargestRadius = 16;
// A window may leave the tangent plane by this much at its rim, in voxels: radius^2 / 2R.
constexpr double kSagitta = 1.0;
constexpr float kStillSmooth = 1;     // flatness up to which windows may grow
constexpr double kSmoothShare = 0.4;  // of the time, before the creases
constexpr double kCleanShare = 0.7;   // before what only noise needs
constexpr int kCreaseLinks = 5;       // links within which a disc of radius 4 matters to a surfel

/// How long the normals of smooth parts may diffuse, so that their windows reach the sagitta.
Result<IdVector<SurfelId, float>> growth(const SurfelLinks& links, const NormalField& normals,
                                         const IdVector<SurfelId, float>& bent,
                                         const RunContext& run) {
    auto rounds = curvatures(links, normals, run);
    if (!rounds) return rounds;
    const bool done = parallelFor(bent.size(), run, [&](std::size_t i) {
        float& value = rounds->raw()[i];
        constexpr float kFlattest = 1e-6F;
        const double radius = std::sqrt(2 * kSagitta / std::max(value, kFlattest));
        value = bent.raw()[i] > kStillSmooth
                    ? 0
                    : static_cast<float>(
                          roundsBetween(kSmoothRadius, std::min(kLargestRadius, radius)));
    });
    if (!done) return fail(run.stopError());
    return rounds;
}

/// Replaces the normals of noisy interfaces.
Result<void> takeRobust(const DigitalSurface& surface, const SurfelLinks& links,
                        const std::vector<double>& noise, const RunContext& run,
                        NormalField& normals) {
    const auto noiseAt = [&](SurfelId s) { return noise[index(surface.interfaceOf[s])]; };
    const auto robust = robustNormals(
        surface, links, [&](SurfelId s) { return noiseAt(s) > 0; }, run.part(kCleanShare, 1));
    if (!robust) return fail(robust.error());
    const bool done = parallelFor(normals.size(), run, [&](std::size_t i) {
        const SurfelId s{static_cast<std::uint32_t>(i)};
        normals[s] = blend(normals[s], (*robust)[s], noiseAt(s));
    });
    if (!done) return fail(run.stopError());
    return {};
}

/// What was chosen, as means over each interface.
std::vector<InterfaceNormals> describe(const DigitalSurface& surface,
                                       const IdVector<SurfelId, float>& creased,
                                       const IdVector<SurfelId, float>& rounds, double radius,
                                       const std::vector<double>& noise, const RunContext& run) {
    std::vector<InterfaceNormals> choices;
    for (const Interface& patch : surface.interfaces) {
        InterfaceNormals& choice = choices.emplace_back();
        choice.noise = noise[choices.size() - 1];
        serialFor(patch.end - patch.begin, run, [&](std::size_t i) {
            const SurfelId s = surface.byInterface[patch.begin + i];
            choice.sharp += creased[s];
            choice.radius += std::sqrt(radius * radius + rounds[s] / roundsBetween(0, 1));
        });
        const double count = std::max<std::uint32_t>(1, patch.end - patch.begin);
        choice.sharp /= count;
        choice.radius /= count;
    }
    return choices;
}

}  // namespace

Result<NormalEstimate> autoNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                   std::optional<double> radius, const RunContext& run) {
    const auto cut = cutSharpEdges(surface, links, run);
    if (!cut) return fail(cut.error());
    auto smooth =
        smoothNormals(surface, *cut, radius.value_or(kSmoothRadius), run.part(0, kSmoothShare));
    if (!smooth) return fail(smooth.error());
    const std::vector<double> noise = noiseLevels(surface, smooth->density, run);
    const bool noisy =
        std::any_of(noise.begin(), noise.end(), [](double level) { return level > 0; });
    auto bent = dilate(*cut, std::move(smooth->flatness), kCreaseLinks, run);
    serialFor(bent.size(), run, [&](std::size_t i) {
        if (noise[index(surface.interfaceOf.raw()[i])] == 1) bent.raw()[i] = 0;
    });
    const auto creases =
        creaseNormals(surface, *cut, bent, run.part(kSmoothShare, noisy ? kCleanShare : 1));
    if (!creases) return fail(creases.error());

    IdVector<SurfelId, float> rounds(surface.surfelCount(), 0);
    if (!radius) {
        auto grown = growth(*cut, smooth->normals, bent, run);
        if (!grown) return fail(grown.error());
        rounds = *std::move(grown);
    }
    auto normals = diffuse(*cut, std::move(smooth->normals), rounds, run);
    if (!normals) return fail(normals.error());
    const bool blended = parallelFor(surface.surfelCount(), run, [&](std::size_t i) {
        const SurfelId s{static_cast<std::uint32_t>(i)};
        (*normals)[s] = blend((*normals)[s].normalized(), creases->normals[s], creases->share[s]);
    });
    if (!blended) return fail(run.stopError());
    if (noisy)
        if (const auto robust = takeRobust(surface, links, noise, run, *normals); !robust)
            return fail(robust.error());
    return NormalEstimate{
        *std::move(normals),
        describe(surface, creases->share, rounds, radius.value_or(kSmoothRadius), noise, run)};
}

Result<NormalField> discVoteNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                    double radius, const RunContext& run) {
    const auto cut = cutSharpEdges(surface, links, run);
    if (!cut) return fail(cut.error());
    DiscVoting voting(surface, radius);
    NormalField normals(surface.surfelCount());
    const auto choose = [&](SurfelId s, PatchWalker& walker) { voting.choose(s, walker); };
    const auto vote = [&](SurfelId s, PatchWalker& walker) {
        normals[s] = voting.vote(s, walker).normal;
    };
    if (!forEachSurfel(surface, *cut, run.part(0, 0.5), choose) ||
        !forEachSurfel(surface, *cut, run.part(0.5, 1), vote))
        return fail(run.stopError());
    return normals;
}

}  // namespace rivage::core
