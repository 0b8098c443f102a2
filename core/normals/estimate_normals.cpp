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

Result<PiecewiseSmoothField> piecewiseSmooth(const DigitalSurface& surface,
                                             const SurfelLinks& links, const NormalOptions& options,
                                             const RunContext& run) {
    constexpr double kInputRadius = 3;
    const auto input = convolvedNormals(surface, links, options.radius.value_or(kInputRadius), run);
    if (!input) return fail(input.error());
    return piecewiseSmoothNormals(surface, links, *input, options.piecewiseSmooth, run);
}

std::uint64_t countFeatures(const IdVector<SurfelId, std::uint8_t>& features) {
    std::uint64_t sides = 0;
    for (const std::uint8_t edges : features) sides += __builtin_popcount(edges);
    return sides / 2;  // both surfels at a feature list it
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

Result<NormalField> estimateNormals(const VoxelGrid& grid, const DigitalSurface& surface,
                                    const SurfelLinks& links, const NormalOptions& options,
                                    const RunContext& run) {
    const auto radius = [&](double usual) { return options.radius.value_or(usual); };
    switch (options.method) {
        case NormalMethod::automatic: {
            auto estimate = autoNormals(surface, links, options.radius, run);
            if (!estimate) return fail(estimate.error());
            return std::move(estimate->normals);
        }
        case NormalMethod::guided: return guidedNormals(surface, links, radius(4), run);
        case NormalMethod::discVote: return discVoteNormals(surface, links, radius(6), run);
        case NormalMethod::convolved: return convolvedNormals(surface, links, radius(4), run);
        case NormalMethod::integralInvariant: {
            const IntegralInvariant invariant(grid, surface, radius(3));
            return estimateEach(surface, links, run, [&](SurfelId s, PatchWalker& walker) {
                return invariant.normal(s, walker);
            });
        }
        case NormalMethod::piecewiseSmooth: {
            auto field = piecewiseSmooth(surface, links, options, run);
            if (!field) return fail(field.error());
            return std::move(field->normals);
        }
        case NormalMethod::robust:
            return robustNormals(
                surface, links, [](SurfelId) { return true; }, run);
        case NormalMethod::trivial: return trivialNormals(surface);
    }
    return fail(ErrorCode::internal, "unknown normal estimator");
}

Result<NormalEstimate> estimateNormalsAndChoices(const VoxelGrid& grid,
                                                 const DigitalSurface& surface,
                                                 const SurfelLinks& links,
                                                 const NormalOptions& options,
                                                 const RunContext& run) {
    if (options.method == NormalMethod::automatic)
        return autoNormals(surface, links, options.radius, run);
    if (options.method == NormalMethod::piecewiseSmooth) {
        auto field = piecewiseSmooth(surface, links, options, run);
        if (!field) return fail(field.error());
        return NormalEstimate{std::move(field->normals), {}, countFeatures(field->features)};
    }
    auto normals = estimateNormals(grid, surface, links, options, run);
    if (!normals) return fail(normals.error());
    return NormalEstimate{*std::move(normals), {}, {}};
}

}  // namespace rivage::core
