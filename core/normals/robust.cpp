#include "core/normals/robust.h"

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
    bool done = forEachSurfel(surface, links, run, [&](SurfelId s, PatchWalker& walker) {
        field[s] = convolvedNormal(surface, walker, s, kStart);
    });
    for (const BilateralWindow& window : kWindows) {
        NormalField next = field;
        done = done && forEachSurfel(surface, links, run, [&](SurfelId s, PatchWalker& walker) {
                   if (wanted(s)) next[s] = bilateralNormal(surface, field, walker, s, window);
               });
        field = std::move(next);
    }
    if (!done) return fail(run.stopError());
    return field;
}

}  // namespace rivage::core
