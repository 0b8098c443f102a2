#include "core/mesh/patch.h"

#include <cassert>

#include "core/base/parallel.h"
#include "core/base/union_find.h"

namespace rivage::core {
namespace {

// The edge of face `s` between two pointels, in either direction.
std::uint32_t edgeBetween(const DigitalSurface& surface, SurfelId s, PointelId a, PointelId b) {
    const auto& corners = surface.corners[s];
    for (std::uint32_t k = 0; k < 4; ++k) {
        const PointelId from = corners[k];
        const PointelId to = corners[(k + 1) & 3U];
        if ((from == a && to == b) || (from == b && to == a)) return k;
    }
    assert(false && "linked surfels share a linel");
    return kNoEdge;
}

}  // namespace

IdVector<SurfelId, std::uint32_t> ranksInInterface(const DigitalSurface& surface,
                                                   const RunContext& run) {
    IdVector<SurfelId, std::uint32_t> ranks(surface.surfelCount());
    for (const Interface& sheet : surface.interfaces)
        serialFor(sheet.end - sheet.begin, run, [&](std::size_t i) {
            ranks[surface.byInterface[sheet.begin + i]] = static_cast<std::uint32_t>(i);
        });
    return ranks;
}

Patch buildPatch(const DigitalSurface& surface, InterfaceId which, const SurfelLinks& links,
                 const IdVector<SurfelId, std::uint32_t>& ranks, const Workers& workers) {
    const Interface& sheet = surface.interfaces[which];
    Patch patch;
    patch.surfels = std::span(surface.byInterface).subspan(sheet.begin, sheet.end - sheet.begin);
    patch.across.assign(patch.cornerCount(), kNoEdge);
    const auto joinFace = [&](std::size_t face) {
        const SurfelId s = patch.surfels[face];
        const auto& corners = surface.corners[s];
        for (std::size_t k = 0; k < 4; ++k) {
            const SurfelId t = links[s][k];
            if (t == kNone<SurfelId>) continue;
            const std::uint32_t edge = edgeBetween(surface, t, corners[k], corners[(k + 1) & 3U]);
            patch.across[4 * face + k] = 4 * ranks[t] + edge;
        }
    };
    parallelBlocks(patch.faceCount(), 2048, workers, [&](std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face < end; ++face) joinFace(face);
    });
    return patch;
}

CornerGroups groupFans(const Patch& patch, const std::vector<std::uint8_t>& joined,
                       const Workers& workers) {
    UnionFind sets(patch.cornerCount());
    serialFor(patch.cornerCount(), workers, [&](std::size_t i) {
        const auto edge = static_cast<std::uint32_t>(i);
        const std::uint32_t other = patch.across[edge];
        // Every pair is seen twice, once from each side.
        if (other == kNoEdge || other < edge || (!joined.empty() && joined[edge] == 0)) return;
        // Faces of one interface wind alike, so they run along a shared linel in opposite ways.
        sets.join(edge, nextCorner(other));
        sets.join(nextCorner(edge), other);
    });
    CornerGroups groups;
    groups.of.resize(patch.cornerCount());
    serialFor(patch.cornerCount(), workers, [&](std::size_t i) {
        const auto c = static_cast<std::uint32_t>(i);
        const std::uint32_t root = sets.find(c);
        groups.of[c] = root == c ? groups.count++ : groups.of[root];
    });
    return groups;
}

}  // namespace rivage::core
