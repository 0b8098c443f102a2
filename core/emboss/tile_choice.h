#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/base/result.h"
#include "core/emboss/tile.h"
#include "core/grid/voxel_grid.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// The tile of one face.
struct FaceTile {
    const HeightTile* tile = nullptr;  ///< none: the face stays smooth
    std::size_t rule = 0;              ///< which rule gave it
    bool ofOuter = false;              ///< it stands out towards the inner side
};

/// Which tile each material has.
class TileChoice {
public:
    /// @param step  distance of samples, voxels
    /// @errors invalidOption if a rule names nothing of the grid
    static Result<TileChoice> make(const VoxelGrid& grid, const EmbossOptions& options,
                                   double step);

    /// That of the inner side; between two regions, where the inner one has none, of the outer.
    [[nodiscard]] FaceTile of(const DigitalSurface& surface, SurfelId s) const;

private:
    std::vector<HeightTile> tiles_;             // one a rule
    IdVector<MaterialId, std::uint32_t> rule_;  // of each material, 1 + its index; 0 for none
};

}  // namespace rivage::core
