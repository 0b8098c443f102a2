#include "core/normals/grow.h"

#include <algorithm>
#include <cmath>

namespace rivage::core {

double roundsBetween(double radius, double larger) {
    // A round moves a step along an axis with variance 2/5; hat weights have 0.15 radius^2.
    constexpr double kRoundsPerSquare = 0.375;
    return std::max(0.0, kRoundsPerSquare * (larger * larger - radius * radius));
}

Result<IdVector<SurfelId, float>> curvatures(const SurfelLinks& links, const NormalField& normals,
                                             const RunContext& run) {
    constexpr float kRounds = 10;  // as wide as hat weights of radius 5
    const IdVector<SurfelId, float> rounds(normals.size(), kRounds);
    const auto mean = diffuse(links, normals, rounds, run);
    if (!mean) return fail(mean.error());
    IdVector<SurfelId, float> squares(normals.size());
    constexpr double kVariance = 0.8;  // of a round, along both axes
    for (std::size_t i = 0; i < normals.size(); ++i)
        squares.raw()[i] = static_cast<float>(std::max(0.0, 1 - mean->raw()[i].squaredNorm()) /
                                              (kVariance * kRounds));
    // Windows of very different sizes side by side would be lopsided, so the estimate is smoothed.
    auto curvature = diffuse(links, std::move(squares), rounds, run);
    if (!curvature) return curvature;
    for (float& value : *curvature) value = std::sqrt(value);
    return curvature;
}

}  // namespace rivage::core
