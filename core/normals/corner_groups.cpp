#include "core/normals/corner_groups.h"

#include <numeric>

#include "core/base/parallel.h"
#include "core/base/union_find.h"

namespace rivage::core {
namespace {

std::uint32_t cornerOf(const DigitalSurface& surface, SurfelId s, PointelId p) {
    std::uint32_t k = 0;
    while (surface.corners[s][k] != p) ++k;
    return 4 * index(s) + k;
}

}  // namespace

InterfacePointels groupCorners(const DigitalSurface& surface, const SurfelLinks& links,
                               const RunContext& run) {
    UnionFind sets(4 * surface.surfelCount());
    serialFor(surface.surfelCount(), run, [&](std::size_t i) {
        const auto f = static_cast<std::uint32_t>(i);
        for (std::uint32_t k = 0; k < 4; ++k) {
            const SurfelId g = links[SurfelId{f}][k];
            if (g == kNone<SurfelId> || index(g) < f) continue;
            for (const std::uint32_t end : {k, (k + 1) & 3U}) {
                const PointelId p = surface.corners[SurfelId{f}][end];
                sets.join(4 * f + end, cornerOf(surface, g, p));
            }
        }
    });
    // The root of a group is its first corner, so groups are numbered in the order of the surfels.
    InterfacePointels groups;
    groups.of.resize(4 * surface.surfelCount());
    serialFor(groups.of.size(), run, [&](std::size_t i) {
        const auto c = static_cast<std::uint32_t>(i);
        const std::uint32_t root = sets.find(c);
        groups.of[c] = root == c ? static_cast<std::uint32_t>(groups.count++) : groups.of[root];
    });
    groups.start.assign(groups.count + 1, 0);
    serialFor(groups.of.size(), run, [&](std::size_t i) { ++groups.start[groups.of[i] + 1]; });
    std::partial_sum(groups.start.begin(), groups.start.end(), groups.start.begin());
    groups.members.resize(groups.of.size());
    std::vector<std::uint32_t> next(groups.start.begin(), groups.start.end() - 1);
    serialFor(groups.of.size(), run, [&](std::size_t i) {
        groups.members[next[groups.of[i]]++] = static_cast<std::uint32_t>(i);
    });
    return groups;
}

}  // namespace rivage::core
