#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/run_context.h"
#include "core/emboss/linels.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// Numbers of the refined pointels: those of the pointels first, then of the linels, then of the
/// surfels; `finish` gives them their final ids, in the order of their places.
///
/// @param surface, linels  must outlive it
/// @param detail           pieces along a linel
class Numbering {
public:
    Numbering(const DigitalSurface& surface, const Linels& linels, int detail)
        : surface_(surface),
          linels_(linels),
          detail_(static_cast<std::size_t>(detail)),
          firstOfLinels_(surface.pointelCount()),
          firstOfSurfels_(firstOfLinels_ + linels.items.size() * (detail_ - 1)) {}

    [[nodiscard]] std::size_t count() const {
        return firstOfSurfels_ + surface_.surfelCount() * (detail_ - 1) * (detail_ - 1);
    }
    /// Point `at` of a linel, 0 at its low end to `detail` at its high end.
    [[nodiscard]] std::size_t onLinel(std::size_t linel, std::size_t at) const {
        if (at == 0) return index(linels_.items[linel].low);
        if (at == detail_) return index(linels_.items[linel].high);
        return firstOfLinels_ + linel * (detail_ - 1) + at - 1;
    }
    /// Point (i, j) of a surfel, (0, 0) at its first corner.
    [[nodiscard]] std::size_t onSurfel(SurfelId s, std::size_t i, std::size_t j) const {
        const auto& edges = linels_.of[s];
        if (j == 0) return onLinel(edges[0], i);
        if (j == detail_) return onLinel(edges[2], i);
        if (i == 0) return onLinel(edges[3], j);
        if (i == detail_) return onLinel(edges[1], j);
        return firstOfSurfels_ + index(s) * (detail_ - 1) * (detail_ - 1) +
               (j - 1) * (detail_ - 1) + i - 1;
    }
    [[nodiscard]] PointelId id(std::size_t number) const { return PointelId{rank_[number]}; }

    /// Sorts by place; what has the same place keeps the order of its numbers.
    [[nodiscard]] bool finish(const std::vector<Vec3i>& places, const RunContext& run);

private:
    const DigitalSurface& surface_;
    const Linels& linels_;
    std::size_t detail_;
    std::size_t firstOfLinels_;
    std::size_t firstOfSurfels_;
    std::vector<std::uint32_t> rank_;
};

}  // namespace rivage::core
