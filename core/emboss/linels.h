#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/run_context.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// A linel that bounds surfels, by its ends.
struct Linel {
    PointelId low;
    PointelId high;
    std::uint8_t axis = 0;   ///< it runs from low to high along this one
    bool aloneAtLow = true;  ///< no other linel runs from `low` the same way: sheets may part there
    bool aloneAtHigh = true;
};

/// The linels of a surface, and which one each edge of a surfel lies on.
struct Linels {
    std::vector<Linel> items;                             ///< by low end, then axis, then high end
    IdVector<SurfelId, std::array<std::uint32_t, 4>> of;  ///< edge k runs from corner k to k + 1
};

/// @return  incomplete once `run` asked to stop
/// @cost    O(surfels) time, 60 bytes a surfel for a while
[[nodiscard]] Linels listLinels(const DigitalSurface& surface, const RunContext& run);

}  // namespace rivage::core
