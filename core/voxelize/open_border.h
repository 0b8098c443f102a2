#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/voxel_grid.h"
#include "core/voxelize/moved_surface.h"
#include "core/voxelize/sample_lattice.h"
#include "core/voxelize/windings.h"

namespace rivage::core {

/// What covers the lower ends of the columns of samples. With a closed border that is the
/// background. With an open one the surface ends on the border of the grid, where its pointels
/// keep to the border, so a path along the border tells: from the corner of the grid along y, then
/// along x, and at each end of an edge, then each edge, that it passes, the label changes.
/// @source  ours
class OpenBorder {
public:
    /// Means nothing once `run` asked to stop.
    /// @cost  O(surfels on the border)
    OpenBorder(const VoxelGrid& grid, const MovedSurface& moved, const SampleLattice& lattice,
               const RunContext& run);

    [[nodiscard]] bool isClosed() const { return !open_; }
    /// Below the columns (xBegin, y), (xBegin + 1, y), ...
    [[nodiscard]] std::vector<Windings> below(int xBegin, int count, int y) const;

private:
    /// The row of columns `line` passes something before `sample`.
    struct Pass {
        std::int64_t line;
        std::int64_t sample;
        Label from;
        Label to;
    };
    void addEdge(const MovedSurface& moved, SurfelId s, PointelId a, PointelId b,
                 const SampleLattice& lattice);

    bool open_ = false;
    Label corner_ = Label{0};
    std::vector<Pass> alongY_;  // on the edge x = z = 0 of the grid, by sample
    std::vector<Pass> alongX_;  // on the side z = 0 of the grid, by row, then sample
};

}  // namespace rivage::core
