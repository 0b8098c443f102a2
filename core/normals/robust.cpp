#include "core/normals/robust.h"

#include <iterator>

#include "core/normals/convolved.h"
#include "core/normals/joint_bilateral.h"
#include "core/normals/surfel_loop.h"

namespace rivage::core {

Result<NormalField> robustNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                  const std::function<bool(SurfelId)>& wanted,
                                  const RunContext& run) {
    constexpr double kStart = 4;
    constexpr BilateralWindow kWindows[] = {
        {.radius = 6, .angle = 0.7}, {.radius = 6, .angle = 0.5}, {8, 0.6, true}};
    NormalField field(surface.surfelCount());
    const double pass = 1.0 / (1 + std::size(kWindows));  // of the time
    double part = pass;
    const auto start = [&](SurfelId s, PatchWalker& walker) {
        field[s] = convolvedNormal(surface, walker, s, kStart);
    };
    bool done = forEachSurfel(surface, links, run.part(0, part), start);
    for (const BilateralWindow& window : kWindows) {
        NormalField next = field;
        const auto smooth = [&](SurfelId s, PatchWalker& walker) {
            if (wanted(s)) next[s] = bilateralNormal(surface, field, walker, s, window);
        };
        done = done && forEachSurfel(surface, links, run.part(part, part + pass), smooth);
        part += pass;
        field = std::move(next);
    }
    if (!done) return fail(run.stopError());
    return field;
}

}  // namespace rivage::core
