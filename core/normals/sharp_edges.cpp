#include "core/normals/sharp_edges.h"

#include <algorithm>
#include <array>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

constexpr int kNoEdge = 4;
constexpr std::uint8_t kWidest = 3;  // surfels; wider strips say no more

/// The edge of `s` whose link is `to`; kNoEdge if there is none.
int edgeTo(const SurfelLinks& links, SurfelId s, SurfelId to) {
    int k = 0;
    while (k < kNoEdge && links[s][k] != to) ++k;
    return k;
}

class SharpEdges {
public:
    SharpEdges(const DigitalSurface& surface, const SurfelLinks& links)
        : surface_(surface), links_(links), width_(surface.surfelCount()) {}

    void measure(SurfelId s) {
        for (int k = 0; k < 4; ++k) {
            width_[s][k] = 0;
            const SurfelId across = links_[s][k];
            if (across == kNone<SurfelId> || surface_.axis[across] == surface_.axis[s]) continue;
            const int back = edgeTo(links_, across, s);
            if (back == kNoEdge) continue;
            width_[s][k] = std::min(stripWidth(s, k), stripWidth(across, back));
        }
    }

    [[nodiscard]] bool isSharp(SurfelId s, int k) const {
        return rowIsLong(s, k, 3, 2) || rowIsLong(s, k, 2, 4);
    }

private:
    // Surfels in a straight line from edge k of s inwards, s counted.
    [[nodiscard]] std::uint8_t stripWidth(SurfelId s, int k) const {
        std::uint8_t width = 1;
        for (int from = k; width < kWidest; ++width) {
            const SurfelId next = links_[s][(from + 2) & 3];
            if (next == kNone<SurfelId> || surface_.axis[next] != surface_.axis[s]) break;
            from = edgeTo(links_, next, s);
            if (from == kNoEdge) break;
            s = next;
        }
        return width;
    }

    // Whether edge k of s lies in a straight row of edges between strips of this width.
    [[nodiscard]] bool rowIsLong(SurfelId s, int k, int width, int length) const {
        if (width_[s][k] < width) return false;
        int found = 1;
        for (const int side : {1, 3}) {
            SurfelId at = s;
            for (int edge = k; found < length; ++found) {
                const SurfelId next = links_[at][(edge + side) & 3];
                if (next == kNone<SurfelId> || surface_.axis[next] != surface_.axis[at]) break;
                const int back = edgeTo(links_, next, at);
                if (back == kNoEdge) break;
                edge = (back + side) & 3;
                if (width_[next][edge] < width) break;
                at = next;
            }
        }
        return found >= length;
    }

    const DigitalSurface& surface_;
    const SurfelLinks& links_;
    IdVector<SurfelId, std::array<std::uint8_t, 4>> width_;  // of the narrower strip; 0: no edge
};

}  // namespace

Result<SurfelLinks> cutSharpEdges(const DigitalSurface& surface, const SurfelLinks& links,
                                  const RunContext& run) {
    SharpEdges edges(surface, links);
    const auto surfel = [](std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; };
    if (!parallelFor(surface.surfelCount(), run, [&](std::size_t i) { edges.measure(surfel(i)); }))
        return fail(run.stopError());
    SurfelLinks cut = links;
    const bool done = parallelFor(surface.surfelCount(), run, [&](std::size_t i) {
        const SurfelId s = surfel(i);
        for (int k = 0; k < 4; ++k) {
            const SurfelId across = links[s][k];
            if (across == kNone<SurfelId>) continue;
            const int back = edgeTo(links, across, s);
            // A row may be seen as long from one side only; either side is enough.
            if (edges.isSharp(s, k) || (back != kNoEdge && edges.isSharp(across, back)))
                cut[s][k] = kNone<SurfelId>;
        }
    });
    if (!done) return fail(run.stopError());
    return cut;
}

}  // namespace rivage::core
