#pragma once

#include <vector>

#include "core/base/options.h"

namespace rivage::core {

/// Heights of a tile, 0 to 1, rows from the bottom.
struct HeightMap {
    int columns = 0;
    int rows = 0;
    std::vector<double> values;
    double size = 4;     ///< width that suits it, voxels
    double depth = 0.2;  ///< depth that suits it, voxels
};

/// One of the tiles that the project makes itself; not for `TileKind::own`.
/// @return  seamless: it continues across its borders
[[nodiscard]] HeightMap makePattern(TileKind kind);

}  // namespace rivage::core
