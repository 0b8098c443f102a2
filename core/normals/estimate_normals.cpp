#include "core/normals/auto_normals.h"
#include "core/normals/convolved.h"
#include "core/normals/guided.h"
#include "core/normals/integral_invariant.h"
#include "core/normals/normal_field.h"
#include "core/normals/piecewise_smooth.h"
#include "core/normals/robust.h"
#include "core/normals/surfel_loop.h"

namespace rivage::core {
namespace {

/// Calls `normal(surfel, walker)` for every surfel.
template <typename Normal>
Result<NormalField> estimateEach(const DigitalSurface& surface, const SurfelLinks& links,
                                 const RunContext& run, Normal&& normal) {
    NormalField normals(surface.surfelCount());
    const bool done = forEachSurfel(surface, links, run, [&](SurfelId s, PatchWalker& walker) {
        normals[s] = normal(s, walker);
    });
    if (!done) return fail(run.stopError());
    return normals;
}

Result<NormalField> convolvedNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                     double radius, const RunContext& run) {
    return estimateEach(surface, links, run, [&](SurfelId s, PatchWalker& walker) {
        return convolvedNormal(surface, walker, s, radius);
    });
}

std::uint64_t countFeatures(const IdVector<SurfelId, std::uint8_t>& features) {
    std::uint64_t sides = 0;
    for (const std::uint8_t edges : features) sides += __builtin_popcount(edges);
    return sides / 2;  // both surfels at a feature list it
}

Result<NormalEstimate> piecewiseSmooth(const DigitalSurface& surface, const SurfelLinks& links,
                                       double radius, const PiecewiseSmoothOptions& options,
                                       const RunContext& run) {
    constexpr double kInputShare = 0.05;  // of the time
    const auto input = convolvedNormals(surface, links, radius, run.part(0, kInputShare));
    if (!input) return fail(input.error());
    auto field = piecewiseSmoothNormals(surface, links, *input, options, run.part(kInputShare, 1));
    if (!field) return fail(field.error());
    return NormalEstimate{std::move(field->normals), {}, countFeatures(field->features)};
}

/// The estimate of a method that tells nothing beside the normals.
Result<NormalEstimate> alone(Result<NormalField> normals) {
    if (!normals) return fail(normals.error());
    return NormalEstimate{*std::move(normals), {}, {}};
}

NormalField trivialNormals(const DigitalSurface& surface) {
    NormalField normals(surface.surfelCount());
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const SurfelId s{static_cast<std::uint32_t>(i)};
        normals[s] = surface.trivialNormal(s).cast<double>();
    }
    return normals;
}

}  // namespace

Result<NormalEstimate> estimateNormalsAndChoices(const VoxelGrid& grid,
                                                 const DigitalSurface& surface,
                                                 const SurfelLinks& links,
                                                 const NormalOptions& options,
                                                 const RunContext& run) {
    const auto radius = [&](double usual) { return options.radius.value_or(usual); };
    switch (options.method) {
        case NormalMethod::automatic: return autoNormals(surface, links, options.radius, run);
        case NormalMethod::guided: return alone(guidedNormals(surface, links, radius(4), run));
        case NormalMethod::discVote: return alone(discVoteNormals(surface, links, radius(6), run));
        case NormalMethod::convolved:
            return alone(convolvedNormals(surface, links, radius(4), run));
        case NormalMethod::integralInvariant: {
            const IntegralInvariant invariant(grid, surface, radius(3));
            return alone(estimateEach(surface, links, run, [&](SurfelId s, PatchWalker& walker) {
                return invariant.normal(s, walker);
            }));
        }
        case NormalMethod::piecewiseSmooth:
            return piecewiseSmooth(surface, links, radius(3), options.piecewiseSmooth, run);
        case NormalMethod::robust:
            return alone(robustNormals(
                surface, links, [](SurfelId) { return true; }, run));
        case NormalMethod::trivial: return alone(trivialNormals(surface));
    }
    return fail(ErrorCode::internal, "unknown normal estimator");
}

Result<NormalField> estimateNormals(const VoxelGrid& grid, const DigitalSurface& surface,
                                    const SurfelLinks& links, const NormalOptions& options,
                                    const RunContext& run) {
    auto estimate = estimateNormalsAndChoices(grid, surface, links, options, run);
    if (!estimate) return fail(estimate.error());
    return std::move(estimate->normals);
}

}  // namespace rivage::core
