#pragma once

#include "core/emboss/frames.h"
#include "core/emboss/tile_choice.h"
#include "core/energy/energy.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// The tile and the frame of one surfel.
struct SurfelTile {
    FaceTile face;
    TileFrame frame;
    double shiftV = 0;  ///< added to v

    [[nodiscard]] double heightAt(const Vec3d& position) const {
        return face.tile->at(frame.u.dot(position), frame.v.dot(position) + shiftV);
    }
};

/// Where the low corner of a grid stands in its scene, in voxel units: tiles are aligned with that.
[[nodiscard]] inline Vec3d sceneOrigin(const VoxelGrid& grid) {
    return grid.origin.cast<double>().cwiseProduct(grid.spacing);
}

/// The surface whose faces get tiles.
struct ChartInput {
    const DigitalSurface& surface;
    const SurfelLinks& links;
    const NormalField& normals;
    const PointelVectors& positions;
    Vec3d origin;  ///< `sceneOrigin`
};

/// Tiles with frames by the normals. Patches of one slope are shifted along v so that courses
/// continue from the patch below or above, as on a barrel roof, wherever the two agree all along
/// their border; walls and level ground keep the world's alignment.
/// @return  incomplete once `run` asked to stop
/// @cost    nearly O(surfels)
/// @source  ours
[[nodiscard]] IdVector<SurfelId, SurfelTile> placeTiles(const ChartInput& input,
                                                        const TileChoice& choice,
                                                        const RunContext& run);

}  // namespace rivage::core
