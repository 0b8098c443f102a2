#include "core/normals/corner_groups.h"

#include <numeric>

namespace rivage::core {
namespace {

std::uint32_t cornerOf(const DigitalSurface& surface, SurfelId s, PointelId p) {
    std::uint32_t k = 0;
    while (surface.corners[s][k] != p) ++k;
    return 4 * index(s) + k;
}

}  // namespace

CornerGroups groupCorners(const DigitalSurface& surface, const SurfelLinks& links) {
    CornerGroups groups;
    std::vector<std::uint32_t>& root = groups.of;
    root.resize(4 * surface.surfelCount());
    std::iota(root.begin(), root.end(), 0U);
    const auto find = [&](std::uint32_t i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    for (std::uint32_t f = 0; f < surface.surfelCount(); ++f)
        for (std::uint32_t k = 0; k < 4; ++k) {
            const SurfelId g = links[SurfelId{f}][k];
            if (g == kNone<SurfelId> || index(g) < f) continue;
            for (const std::uint32_t end : {k, (k + 1) & 3U}) {
                const PointelId p = surface.corners[SurfelId{f}][end];
                const std::uint32_t a = find(4 * f + end);
                const std::uint32_t b = find(cornerOf(surface, g, p));
                root[std::max(a, b)] = std::min(a, b);
            }
        }
    // The root of a group is its first corner, so groups are numbered in the order of the surfels.
    std::vector<std::uint32_t> number(root.size());
    for (std::uint32_t i = 0; i < root.size(); ++i) {
        const std::uint32_t first = find(i);
        number[i] = first == i ? static_cast<std::uint32_t>(groups.count++) : number[first];
    }
    root = std::move(number);
    groups.start.assign(groups.count + 1, 0);
    for (const std::uint32_t group : groups.of) ++groups.start[group + 1];
    std::partial_sum(groups.start.begin(), groups.start.end(), groups.start.begin());
    groups.members.resize(groups.of.size());
    std::vector<std::uint32_t> next(groups.start.begin(), groups.start.end() - 1);
    for (std::uint32_t i = 0; i < groups.of.size(); ++i) groups.members[next[groups.of[i]]++] = i;
    return groups;
}

}  // namespace rivage::core
