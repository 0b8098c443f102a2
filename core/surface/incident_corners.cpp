#include "core/surface/incident_corners.h"

#include <array>
#include <cstddef>

namespace rivage::core {

IncidentCorners incidentCorners(const DigitalSurface& surface, const Workers& workers) {
    IncidentCorners around;
    around.start.assign(surface.pointelCount() + 1, 0);
    const auto cornersOf = [&](std::size_t f) -> const std::array<PointelId, 4>& {
        return surface.corners[SurfelId{static_cast<std::uint32_t>(f)}];
    };
    serialFor(surface.surfelCount(), workers, [&](std::size_t f) {
        for (const PointelId p : cornersOf(f)) ++around.start[index(p) + 1U];
    });
    for (std::size_t n = 0; n < surface.pointelCount(); ++n) around.start[n + 1] += around.start[n];
    around.corners.resize(surface.surfelCount() * 4);
    std::vector<std::uint32_t> next(around.start.begin(), around.start.end() - 1);
    serialFor(surface.surfelCount(), workers, [&](std::size_t f) {
        for (std::size_t k = 0; k < 4; ++k)
            around.corners[next[index(cornersOf(f)[k])]++] = static_cast<std::uint32_t>(4 * f + k);
    });
    return around;
}

}  // namespace rivage::core
