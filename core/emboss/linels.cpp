#include "core/emboss/linels.h"

#include <algorithm>
#include <tuple>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }

/// An edge of a surfel, kept with the low end of its linel.
struct Edge {
    std::uint8_t axis;
    PointelId high;
    std::uint32_t number;  // 4 s + k
    auto operator<=>(const Edge&) const = default;
};

struct Ends {
    PointelId low;
    PointelId high;
    std::uint8_t axis;
};

Ends endsOf(const DigitalSurface& surface, SurfelId s, std::size_t k) {
    const PointelId a = surface.corners[s][k];
    const PointelId b = surface.corners[s][(k + 1) & 3U];
    const Vec3i step = surface.pointels[b] - surface.pointels[a];
    const std::uint8_t axis = step.x() != 0 ? 0 : step.y() != 0 ? 1 : 2;
    return step[axis] > 0 ? Ends{a, b, axis} : Ends{b, a, axis};
}

/// The edges of all surfels: those of low end i are items[start[i]] to items[start[i + 1]], by
/// linel.
struct EdgeLists {
    std::vector<std::uint64_t> start;
    std::vector<Edge> items;

    EdgeLists(const DigitalSurface& surface, const RunContext& run)
        : start(surface.pointelCount() + 1), items(4 * surface.surfelCount()) {
        const auto forEachEdge = [&](auto&& visit) {
            serialFor(surface.surfelCount(), run, [&](std::size_t i) {
                for (std::size_t k = 0; k < 4; ++k)
                    visit(endsOf(surface, surfel(i), k), static_cast<std::uint32_t>(4 * i + k));
            });
        };
        forEachEdge([&](const Ends& ends, std::uint32_t) { ++start[index(ends.low) + 1U]; });
        for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
        std::vector<std::uint64_t> next(start.begin(), start.end() - 1);
        forEachEdge([&](const Ends& ends, std::uint32_t number) {
            items[next[index(ends.low)]++] = {ends.axis, ends.high, number};
        });
    }
};

/// How many linels run from each pointel in each slot, at most 3 counted.
using SlotCounts = IdVector<PointelId, std::array<std::uint8_t, kSlots>>;

void countSlots(const Linels& linels, const RunContext& run, SlotCounts& counts) {
    serialFor(linels.items.size(), run, [&](std::size_t i) {
        const Linel& linel = linels.items[i];
        for (std::uint8_t* count :
             {&counts[linel.low][2 * linel.axis + 1], &counts[linel.high][2 * linel.axis]})
            *count = static_cast<std::uint8_t>(std::min(*count + 1, 3));
    });
}

}  // namespace

Linels listLinels(const DigitalSurface& surface, const RunContext& run) {
    Linels linels;
    linels.of.resize(surface.surfelCount());
    linels.items.reserve(2 * surface.surfelCount());
    EdgeLists edges(surface, run);
    serialFor(surface.pointelCount(), run, [&](std::size_t i) {
        const auto begin = edges.items.begin() + static_cast<std::ptrdiff_t>(edges.start[i]);
        const auto end = edges.items.begin() + static_cast<std::ptrdiff_t>(edges.start[i + 1]);
        std::sort(begin, end);
        for (auto at = begin; at != end; ++at) {
            if (at == begin || at->axis != (at - 1)->axis || at->high != (at - 1)->high)
                linels.items.push_back(
                    {PointelId{static_cast<std::uint32_t>(i)}, at->high, at->axis});
            linels.of[surfel(at->number / 4)][at->number % 4] =
                static_cast<std::uint32_t>(linels.items.size() - 1);
        }
    });
    SlotCounts counts(surface.pointelCount());
    countSlots(linels, run, counts);
    for (Linel& linel : linels.items) {
        linel.aloneAtLow = counts[linel.low][2 * linel.axis + 1] == 1;
        linel.aloneAtHigh = counts[linel.high][2 * linel.axis] == 1;
    }
    return linels;
}

}  // namespace rivage::core
