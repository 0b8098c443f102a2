#pragma once

#include <vector>

#include "core/base/options.h"

namespace rivage::core {

/// A height tile that is ready to be sampled: periodic, in voxels, about its own mean, so that the
/// surface as a whole stays where it is.
class HeightTile {
public:
    /// @param step  distance of the samples, voxels: what is finer is averaged, so that nothing
    ///              flickers and no joint is lost
    HeightTile(const TileOptions& options, double step);

    /// The height at (u, v): u to the right and v upwards seen from outside, voxels; positive
    /// stands out. Bilinear between the heights.
    [[nodiscard]] double at(double u, double v) const;
    /// Highest less lowest, voxels, before averaging.
    [[nodiscard]] double range() const { return range_; }

private:
    int columns_ = 1;
    int rows_ = 1;
    double perVoxelU_ = 1;  // columns a voxel
    double perVoxelV_ = 1;
    int quarterTurns_ = 0;
    double range_ = 0;
    std::vector<double> heights_;  // rows from the bottom
};

/// What the caller calls a tile: "brick", ..., "own".
[[nodiscard]] const char* tileName(TileKind kind);

}  // namespace rivage::core
