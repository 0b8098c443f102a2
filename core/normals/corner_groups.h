#pragma once

#include <cstdint>
#include <vector>

#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// The pointels of the interfaces taken apart: corners of surfels belong to one group if a chain of
/// links around their common pointel joins them.
struct InterfacePointels {
    std::size_t count = 0;
    std::vector<std::uint32_t> of;       ///< group of corner k of surfel f at 4 f + k
    std::vector<std::uint32_t> start;    ///< members[start[i] .. start[i + 1]) are group i's
    std::vector<std::uint32_t> members;  ///< corners as 4 f + k, ascending
};

/// @cost O(surfels), 36 bytes a surfel
InterfacePointels groupCorners(const DigitalSurface& surface, const SurfelLinks& links,
                               const RunContext& run);

}  // namespace rivage::core
