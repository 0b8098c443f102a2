#include "core/mesh/closed.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

// An edge of a face, kept with the lower of its pointels.
struct HalfEdge {
    PointelId high;
    SurfelId face;
};

std::pair<PointelId, PointelId> edgeOf(const DigitalSurface& surface, SurfelId s, std::size_t k) {
    const auto& corners = surface.corners[s];
    return std::minmax(corners[k], corners[(k + 1) & 3U]);
}

// The edges of all faces by their lower pointels: those of pointel i are items[start[i]] to
// items[start[i + 1]].
struct EdgeTable {
    std::vector<std::size_t> start;
    std::vector<HalfEdge> items;

    EdgeTable(const DigitalSurface& surface, const RunContext& run)
        : start(surface.pointelCount() + 1), items(4 * surface.surfelCount()) {
        const auto forEachEdge = [&](auto&& visit) {
            serialFor(surface.surfelCount(), run, [&](std::size_t i) {
                const SurfelId s{static_cast<std::uint32_t>(i)};
                for (std::size_t k = 0; k < 4; ++k) visit(s, edgeOf(surface, s, k));
            });
        };
        forEachEdge([&](SurfelId, const auto& edge) { ++start[index(edge.first) + 1U]; });
        for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
        std::vector<std::size_t> next(start.begin(), start.end() - 1);
        forEachEdge([&](SurfelId s, const auto& edge) {
            items[next[index(edge.first)]++] = {edge.second, s};
        });
    }
};

bool liesOnBorder(const DigitalSurface& surface, PointelId a, PointelId b) {
    if (surface.fixedAxes.empty()) return false;
    for (int axis = 0; axis < 3; ++axis)
        if ((surface.fixedAxes[a] & surface.fixedAxes[b]) >> axis & 1 &&
            surface.pointels[a][axis] == surface.pointels[b][axis])
            return true;
    return false;
}

// Marks the labels that have an odd number of the faces of one edge.
void checkEdge(const DigitalSurface& surface, std::span<const HalfEdge> faces, Closure found,
               std::vector<Closure>& closures) {
    const auto sides = [&](const HalfEdge& edge) {
        return surface.interfaces[surface.interfaceOf[edge.face]].labels;
    };
    const auto countFaces = [&](Label label) {
        return std::count_if(faces.begin(), faces.end(), [&](const HalfEdge& edge) {
            return sides(edge).inner == label || sides(edge).outer == label;
        });
    };
    for (const HalfEdge& edge : faces)
        for (const Label label : {sides(edge).inner, sides(edge).outer})
            if (label != Label{0} && countFaces(label) % 2 != 0) {
                Closure& closure = closures[index(label) - 1U];
                closure = std::max(closure, found);
            }
}

}  // namespace

std::vector<Closure> labelClosures(const VoxelGrid& grid, const DigitalSurface& surface,
                                   const RunContext& run) {
    std::vector<Closure> closures(grid.labels.size() - 1, Closure::closed);
    EdgeTable edges(surface, run);
    serialFor(surface.pointelCount(), run, [&](std::size_t n) {
        const auto i = static_cast<std::uint32_t>(n);
        const auto begin = edges.items.begin() + static_cast<std::ptrdiff_t>(edges.start[i]);
        const auto end = edges.items.begin() + static_cast<std::ptrdiff_t>(edges.start[i + 1]);
        std::sort(begin, end, [](const HalfEdge& a, const HalfEdge& b) { return a.high < b.high; });
        for (auto from = begin; from != end;) {
            const auto to = std::find_if(
                from, end, [&](const HalfEdge& edge) { return edge.high != from->high; });
            const bool border = liesOnBorder(surface, PointelId{i}, from->high);
            checkEdge(surface, {from, to}, border ? Closure::openAtBorder : Closure::open,
                      closures);
            from = to;
        }
    });
    return closures;
}

}  // namespace rivage::core
