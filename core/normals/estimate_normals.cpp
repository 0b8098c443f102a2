#include "core/base/parallel.h"
#include "core/normals/convolved.h"
#include "core/normals/integral_invariant.h"
#include "core/normals/normal_field.h"

namespace rivage::core {
namespace {

/// Calls `normal(surfel, walker)` for every surfel; a walker serves a block of surfels.
template <typename Normal>
Result<NormalField> estimateEach(const DigitalSurface& surface, const SurfelLinks& links,
                                 const RunContext& run, Normal&& normal) {
    NormalField normals(surface.surfelCount());
    constexpr std::size_t kBlock = 512;
    parallelBlocks(surface.surfelCount(), kBlock, run.threads,
                   [&](std::size_t begin, std::size_t end) {
                       if (run.stopped()) return;
                       PatchWalker walker(surface, links);
                       for (std::size_t i = begin; i < end; ++i) {
                           const SurfelId s{static_cast<std::uint32_t>(i)};
                           normals[s] = normal(s, walker);
                       }
                   });
    if (run.stopped()) return fail(run.stopError());
    return normals;
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
    switch (options.method) {
        case NormalMethod::trivial: return trivialNormals(surface);
        case NormalMethod::convolved:
            return estimateEach(surface, links, run, [&](SurfelId s, PatchWalker& walker) {
                return convolvedNormal(surface, walker, s, options.radius);
            });
        case NormalMethod::integralInvariant: {
            const IntegralInvariant invariant(grid, surface, options.radius);
            return estimateEach(surface, links, run, [&](SurfelId s, PatchWalker& walker) {
                return invariant.normal(s, walker);
            });
        }
    }
    return fail(ErrorCode::internal, "unknown normal estimator");
}

}  // namespace rivage::core
