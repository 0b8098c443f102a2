#include "core/surface/surfel_links.h"

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

/// The surfels around the linel from `low` along `direction`; kNone where there is none.
std::array<SurfelId, 4> surfelsAround(const DigitalSurface& surface, PointelId low, int direction) {
    const int b = (direction + 1) % 3;
    const int c = (direction + 2) % 3;
    const auto& slots = surface.neighbours[low];
    return {surface.surfelAt(low, c), surface.surfelAt(slots[2 * b], c), surface.surfelAt(low, b),
            surface.surfelAt(slots[2 * c], b)};
}

bool shareVoxel(const DigitalSurface& surface, SurfelId s, SurfelId g, bool inner) {
    return inner ? surface.innerVoxel(s) == surface.innerVoxel(g)
                 : surface.outerVoxel(s) == surface.outerVoxel(g);
}

SurfelId linkAcross(const DigitalSurface& surface, SurfelId s, PointelId low, int direction) {
    const InterfaceId patch = surface.interfaceOf[s];
    std::array<SurfelId, 4> others{};
    int count = 0;
    for (const SurfelId g : surfelsAround(surface, low, direction))
        if (g != kNone<SurfelId> && g != s && surface.interfaceOf[g] == patch) others[count++] = g;
    if (count == 1) return others[0];
    const Interface& rule = surface.interfaces[patch];
    if (count != 3 || !rule.pairs) return kNone<SurfelId>;
    for (int i = 0; i < count; ++i)
        if (shareVoxel(surface, s, others[i], rule.through == rule.labels.inner)) return others[i];
    return kNone<SurfelId>;
}

}  // namespace

Result<SurfelLinks> linkSurfels(const DigitalSurface& surface, const RunContext& run) {
    SurfelLinks links(surface.surfelCount());
    const bool done = parallelFor(surface.surfelCount(), run, [&](std::size_t i) {
        const SurfelId s{static_cast<std::uint32_t>(i)};
        const auto& corners = surface.corners[s];
        for (int k = 0; k < 4; ++k) {
            const PointelId a = corners[k];
            const PointelId b = corners[(k + 1) % 4];
            const Vec3i step = surface.pointels[b] - surface.pointels[a];
            const int direction = step.x() != 0 ? 0 : step.y() != 0 ? 1 : 2;
            links[s][k] = linkAcross(surface, s, step[direction] > 0 ? a : b, direction);
        }
    });
    if (!done) return fail(run.stopError());
    return links;
}

}  // namespace rivage::core
