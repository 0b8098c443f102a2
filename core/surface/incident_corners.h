#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// Which corners of surfels are at each pointel: corner k of surfel f is the number 4 f + k.
struct IncidentCorners {
    std::vector<std::uint32_t> start;    ///< by pointel, and one more
    std::vector<std::uint32_t> corners;  ///< by pointel, ascending

    [[nodiscard]] std::span<const std::uint32_t> of(PointelId p) const {
        return std::span(corners).subspan(start[index(p)], start[index(p) + 1U] - start[index(p)]);
    }
};

/// @return  some corners are missing once `workers` were asked to stop
/// @cost    O(surfels), 16 bytes a surfel and 4 a pointel
[[nodiscard]] IncidentCorners incidentCorners(const DigitalSurface& surface,
                                              const Workers& workers);

}  // namespace rivage::core
