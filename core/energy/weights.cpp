#include "core/energy/weights.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

using Factors = Eigen::Array3d;  // of alpha, beta, gamma

std::string listOf(const IdVector<Label, std::string>& labels) {
    constexpr std::size_t kMost = 8;
    std::string text;
    for (std::size_t l = 1; l < std::min(labels.size(), kMost + 1); ++l)
        text += (l == 1 ? "" : ", ") + labels.raw()[l];
    return labels.size() > kMost + 1 ? text + ", ..." : text;
}

Result<IdVector<Label, Factors>> factorsOf(const IdVector<Label, std::string>& labels,
                                           const std::vector<RegionWeights>& regions) {
    IdVector<Label, Factors> factors(labels.size(), Factors::Ones());
    for (const RegionWeights& region : regions)
        if (region.region == "*")
            std::fill(factors.begin(), factors.end(),
                      Factors(region.alpha, region.beta, region.gamma));
    for (const RegionWeights& region : regions) {
        if (region.region == "*") continue;
        const auto found = std::find(labels.begin() + 1, labels.end(), region.region);
        if (found == labels.end())
            return fail(ErrorCode::invalidOption,
                        "weights names \"" + region.region +
                            "\", which is no region of this grid; it has " + listOf(labels),
                        "/options/weights/" + region.region);
        factors.raw()[static_cast<std::size_t>(found - labels.begin())] =
            Factors(region.alpha, region.beta, region.gamma);
    }
    return factors;
}

Factors ofSurfel(const DigitalSurface& surface, const IdVector<Label, Factors>& factors,
                 SurfelId s) {
    const LabelPair labels = surface.interfaces[surface.interfaceOf[s]].labels;
    if (labels.outer == Label{0}) return factors[labels.inner];
    return 0.5 * (factors[labels.inner] + factors[labels.outer]);
}

}  // namespace

Result<EnergyWeights> weightsByRegion(const DigitalSurface& surface,
                                      const IdVector<Label, std::string>& labels,
                                      const EnergyOptions& options, const RunContext& run) {
    const auto factors = factorsOf(labels, options.regions);
    if (!factors) return fail(factors.error());
    EnergyWeights weights = EnergyWeights::uniform(surface, options);
    if (options.regions.empty()) return weights;

    IdVector<PointelId, Factors> sums(surface.pointelCount(), Factors::Zero());
    IdVector<PointelId, int> counts(surface.pointelCount());
    serialFor(surface.surfelCount(), run, [&](std::size_t i) {
        const SurfelId s{static_cast<std::uint32_t>(i)};
        const Factors own = ofSurfel(surface, *factors, s);
        weights.beta[s] *= own[1];
        for (const PointelId p : surface.corners[s]) {
            sums[p] += own;
            ++counts[p];
        }
    });
    const bool done = parallelFor(surface.pointelCount(), run, [&](std::size_t i) {
        const PointelId p{static_cast<std::uint32_t>(i)};
        weights.alpha[p] *= sums[p][0] / counts[p];
        weights.gamma[p] *= sums[p][2] / counts[p];
    });
    if (!done) return fail(run.stopError());
    return weights;
}

}  // namespace rivage::core
