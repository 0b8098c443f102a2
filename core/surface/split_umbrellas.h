#pragma once

#include <cstddef>

#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// Gives each fan of surfels around a pointel a pointel of its own on the same lattice place, so
/// that sheets that only touch there may move apart: walls one voxel thick in diagonal directions,
/// voxels that meet in an edge or a corner.
///
/// A fan is a connected set of the surfels around the pointel: two of them hang together if they
/// are linked, if they share a junction linel (the interfaces that meet there keep their pointels
/// in common), or if they share a linel where four sheets of an interface meet unpaired. The
/// surfels around a linel are joined alike at both of its ends, in pairs or all, so the faces
/// around every edge stay even in number for each label.
///
/// Where the two pairs of sheets of a linel hang together at one end only, the end of a slit, two
/// edges run from there to two copies. The neighbour table has one place for them, and must be
/// symmetric, so it has neither: fairness does without this linel, alignment does not.
///
/// Copies stand next to each other, in the order of their first surfels. `firstSurfel` and
/// `surfelAxes` are empty afterwards, so `surfelAt` must not be called; the surfels keep their ids,
/// and `links` stays true.
/// @param surface  not split yet
/// @return  how many pointels were split
/// @errors  tooLarge if there would be 2^32 - 1 pointels; cancelled
/// @cost    O(pointels + surfels) time; 20 bytes a surfel and 30 a pointel for a while
/// @source  ours; METHOD.md 2.6
Result<std::size_t> splitUmbrellas(DigitalSurface& surface, const SurfelLinks& links,
                                   const RunContext& run);

/// Whether a pointel is one of several on its lattice place.
[[nodiscard]] inline bool isSplit(const DigitalSurface& surface, PointelId p) {
    const auto same = [&](std::uint32_t other) {
        return surface.pointels[PointelId{other}] == surface.pointels[p];
    };
    const std::uint32_t i = index(p);
    return (i > 0 && same(i - 1)) || (i + 1 < surface.pointelCount() && same(i + 1));
}

}  // namespace rivage::core
