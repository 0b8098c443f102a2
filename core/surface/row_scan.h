#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/grid/voxel_grid.h"

namespace rivage::core {

/// Looks at one row of pointels (0..nx, y, z) at a time through the four rows of voxels around it.
/// Behind an open border the voxels next to it go on, so that they differ nowhere across it.
class RowScan {
public:
    /// The four rows of voxels around a row of pointels.
    enum Row : std::uint8_t { lowYlowZ, highYlowZ, lowYhighZ, highYhighZ };

    /// @param storedRows  `grid.voxels.storedRows()`: rows of empty bricks are not even read
    RowScan(const VoxelGrid& grid, const std::vector<bool>& storedRows);

    /// Moves to the pointels of row (y, z). Cheap when called with y + 1 after y.
    void moveTo(int y, int z);
    /// False if the four rows are empty, so that no pointel is in this row.
    [[nodiscard]] bool maybe() const { return any_[0] || any_[1] || any_[2] || any_[3]; }
    /// The label of the voxel (x, row), for x from -1 to nx.
    [[nodiscard]] Label label(Row row, int x) const { return labels_[row][x + 1]; }
    [[nodiscard]] MaterialId material(Row row, int x) const { return materials_[row][x + 1]; }
    /// True if the 8 voxels around pointel x do not all share one label.
    [[nodiscard]] bool isPointel(int x) const {
        return !(uniform(x - 1) && uniform(x) && label(highYhighZ, x - 1) == label(highYhighZ, x));
    }
    /// Slots whose linel has not one label all around, and those with 3 labels or more.
    struct Linels {
        std::uint8_t present = 0;
        std::uint8_t junction = 0;
    };
    [[nodiscard]] Linels linelsAt(int x) const;
    /// Axes of the surfels whose lowest corner is pointel x, as bits.
    [[nodiscard]] std::uint8_t surfelAxesAt(int x) const;
    /// Axes across the sides of the grid that pointel x lies on, as bits.
    [[nodiscard]] std::uint8_t fixedAxesAt(int x) const;

private:
    [[nodiscard]] bool uniform(int x) const {
        const Label l = label(highYhighZ, x);
        return label(lowYlowZ, x) == l && label(highYlowZ, x) == l && label(lowYhighZ, x) == l;
    }
    [[nodiscard]] bool isStored(int y, int z) const;
    /// The row of voxels to look at for row y: behind an open border the last row goes on.
    [[nodiscard]] int inside(int y, int axis) const;
    void load(int row, int outerY, int outerZ);
    /// Slots of pointel x that do not leave the grid, as bits.
    [[nodiscard]] unsigned slotsInside(int x) const;

    const VoxelGrid& grid_;
    const std::vector<bool>& storedRows_;
    int y_ = -2;
    int z_ = -2;
    std::array<std::vector<MaterialId>, 4> materials_;
    std::array<std::vector<Label>, 4> labels_;
    std::array<bool, 4> any_{};  // false: the whole row is empty
};

}  // namespace rivage::core
