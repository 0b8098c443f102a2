#include "core/normals/noise_level.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/normals/blend.h"

namespace rivage::core {
namespace {

constexpr std::size_t kFewSurfels = 1000;  // say nothing about their statistics
constexpr double kClean = 0.05;            // density up to which the labels count as clean
constexpr double kNoisy = 0.10;            // density from which they count as noisy

bool standsOut(const DigitalSurface& surface, const SurfelLinks& links, SurfelId s) {
    for (const SurfelId one : links[s]) {
        if (one == kNone<SurfelId>) continue;
        for (const SurfelId two : links[one])
            if (two != kNone<SurfelId> && surface.axis[two] == surface.axis[s] &&
                surface.innerIsLow[two] != surface.innerIsLow[s])
                return true;
    }
    return false;
}

/// The density that a quarter of the surfels stay below, as a level.
double levelOf(std::vector<float> densities) {
    if (densities.size() < kFewSurfels) return 0;
    const auto quarter = densities.begin() + static_cast<std::ptrdiff_t>(densities.size() / 4);
    std::nth_element(densities.begin(), quarter, densities.end());
    return smoothstep(kClean, kNoisy, *quarter);
}

}  // namespace

IdVector<SurfelId, std::uint8_t> findStandouts(const DigitalSurface& surface,
                                               const SurfelLinks& links, const RunContext& run) {
    IdVector<SurfelId, std::uint8_t> stands(surface.surfelCount());
    parallelBlocks(surface.surfelCount(), 4096, run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const SurfelId s{static_cast<std::uint32_t>(i)};
            stands[s] = standsOut(surface, links, s);
        }
    });
    return stands;
}

std::vector<double> noiseLevels(const DigitalSurface& surface,
                                const IdVector<SurfelId, float>& density, const RunContext& run) {
    const double together = levelOf({density.begin(), density.end()});
    std::vector<double> levels;
    for (const Interface& patch : surface.interfaces) {
        if (patch.end - patch.begin < kFewSurfels) {
            levels.push_back(together);
            continue;
        }
        std::vector<float> own;
        serialFor(patch.end - patch.begin, run, [&](std::size_t i) {
            own.push_back(density[surface.byInterface[patch.begin + i]]);
        });
        levels.push_back(levelOf(std::move(own)));
    }
    return levels;
}

}  // namespace rivage::core
