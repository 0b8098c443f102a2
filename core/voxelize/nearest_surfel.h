#pragma once

#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/voxelize/moved_surface.h"

namespace rivage::core {

/// Finds the face of a label that is nearest to a point, by the middles of the moved faces.
class NearestSurfel {
public:
    struct Hit {
        SurfelId surfel = kNone<SurfelId>;  ///< none: the label has no face
        double squaredDistance = 0;         ///< squares of the shortest side of a voxel
    };

    /// @param moved  must outlive the table
    /// @param grid   voxels along x, y, z
    /// @errors cancelled
    /// @cost   O(surfels) time, 8 bytes a surfel and 8 a row of voxels
    static Result<NearestSurfel> build(const MovedSurface& moved, const Vec3i& grid,
                                       const RunContext& run);

    /// @param at     voxels, anywhere
    /// @param label  on either side of the face
    /// @return       on a tie the face with the smaller id
    /// @cost         a few hundred faces near the surface of the label
    [[nodiscard]] Hit find(const Vec3d& at, Label label) const;
    /// The material of the input voxel on the side of a face that has a label.
    [[nodiscard]] MaterialId materialOf(SurfelId s, Label label) const {
        const DigitalSurface& surface = moved_->surface;
        return moved_->labels(s).inner == label ? surface.innerMaterial[s]
                                                : surface.outerMaterial[s];
    }

private:
    NearestSurfel(const MovedSurface& moved, const Vec3i& grid) : moved_(&moved), grid_(grid) {}
    [[nodiscard]] Vec3i cellOf(const Vec3d& at) const;
    [[nodiscard]] std::size_t row(int y, int z) const {
        return y + static_cast<std::size_t>(z) * grid_.y();
    }
    void visitRow(int y, int z, int xBegin, int xEnd, const Vec3d& at, Label label,
                  Hit& best) const;
    void visitRing(const Vec3i& cell, int ring, const Vec3d& at, Label label, Hit& best) const;

    struct Entry {
        std::int32_t x;  // cell of the face's middle
        SurfelId surfel;
    };
    const MovedSurface* moved_;
    Vec3i grid_;
    std::vector<std::size_t> rows_;  // first entry of each row of cells
    std::vector<Entry> entries_;     // by row, then x, then surfel
};

}  // namespace rivage::core
