#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/run_context.h"
#include "core/emboss/charts.h"
#include "core/emboss/emboss.h"
#include "core/solve/box.h"

namespace rivage::core {

/// What the tiles want of a refined surface.
struct Relief {
    /// Heights at the four corners of each piece, voxels along its normal; 0 without a tile.
    IdVector<SurfelId, std::array<float, 4>> heights;
    IdVector<PointelId, Room> rooms;
    std::vector<std::uint64_t> surfelsOfRule;  ///< whole surfels
};

/// @param tiles  of the surfels before they were cut
/// @param limit  the displacement limit in voxels of the unrefined lattice; none: no such limit
/// @return  incomplete once `run` asked to stop
[[nodiscard]] Relief makeRelief(const EmbossInput& input, const RefinedSurface& refined,
                                const IdVector<SurfelId, SurfelTile>& tiles, std::size_t rules,
                                std::optional<double> limit, const RunContext& run);

/// Unit normals of the pieces at rest, and those that their heights ask for: the normals of the
/// pieces with each corner lifted along the normal by its height.
struct PieceNormals {
    NormalField rest;
    NormalField wanted;
};
[[nodiscard]] PieceNormals pieceNormals(const RefinedSurface& refined, const Relief& relief,
                                        const RunContext& run);

/// Moves each pointel by the mean of the heights there along the mean normal m of its pieces, by
/// m / |m|^2, so that all pieces that meet at a crease move by their height; inside its room.
[[nodiscard]] PointelVectors displaced(const RefinedSurface& refined, const Relief& relief,
                                       const NormalField& normals, const RunContext& run);

}  // namespace rivage::core
