#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

inline constexpr std::uint32_t kNoEdge = 0xffffffff;

/// One interface as a mesh of quads. Face i is surfel `surfels[i]`; corner 4 i + k is its k-th
/// corner, and edge 4 i + k runs from that corner to the next one.
struct Patch {
    std::span<const SurfelId> surfels;
    /// The edge of the neighbouring face that lies on the same linel, kNoEdge at a border.
    std::vector<std::uint32_t> across;

    [[nodiscard]] std::size_t faceCount() const { return surfels.size(); }
    [[nodiscard]] std::size_t cornerCount() const { return 4 * surfels.size(); }
    [[nodiscard]] SurfelId surfelOf(std::size_t corner) const { return surfels[corner / 4]; }
    [[nodiscard]] PointelId pointelOf(const DigitalSurface& surface, std::size_t corner) const {
        return surface.corners[surfels[corner / 4]][corner % 4];
    }
};

/// The corner that follows (precedes) a corner in its own face.
[[nodiscard]] constexpr std::uint32_t nextCorner(std::uint32_t corner) {
    return (corner & ~3U) | ((corner + 1) & 3U);
}
[[nodiscard]] constexpr std::uint32_t previousCorner(std::uint32_t corner) {
    return (corner & ~3U) | ((corner + 3) & 3U);
}

/// Ranks of all surfels within their interfaces.
[[nodiscard]] IdVector<SurfelId, std::uint32_t> ranksInInterface(const DigitalSurface& surface,
                                                                 const RunContext& run = {});

/// An interface with its faces joined across linels as `linkSurfels` joins surfels: the two sides
/// of a thin sheet stay apart.
/// @param ranks  of `ranksInInterface`
/// @return       `across` is its own inverse; the same for any thread count
/// @cost         O(faces) time, 16 bytes a face
[[nodiscard]] Patch buildPatch(const DigitalSurface& surface, InterfaceId which,
                               const SurfelLinks& links,
                               const IdVector<SurfelId, std::uint32_t>& ranks,
                               const Workers& workers);

/// A partition of the corners of a patch.
struct CornerGroups {
    std::vector<std::uint32_t> of;  ///< group of each corner, numbered by first corner
    std::uint32_t count = 0;
};

/// Corners that are connected by a fan of faces around their pointel. In this thread; means nothing
/// once the workers are asked to stop.
/// @param joined  one flag an edge: whether fans continue across it; empty means all do
/// @cost          nearly O(corners) time, 8 bytes a corner
[[nodiscard]] CornerGroups groupFans(const Patch& patch, const std::vector<std::uint8_t>& joined,
                                     const Workers& workers = 1);

}  // namespace rivage::core
