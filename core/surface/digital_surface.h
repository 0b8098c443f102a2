#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/base/vec.h"
#include "core/grid/voxel_grid.h"

namespace rivage::core {

/// The two labels of a surfel. The background is always outer, otherwise inner < outer.
struct LabelPair {
    Label inner;
    Label outer;
    auto operator<=>(const LabelPair&) const = default;
};

/// All surfels with one label pair.
struct Interface {
    LabelPair labels;
    std::uint32_t begin = 0;  ///< range in `DigitalSurface::byInterface`
    std::uint32_t end = 0;
    /// Where four surfels of this interface meet at a linel, the two that share a voxel of this
    /// label are neighbours, so that the two sides of a thin diagonal sheet stay apart:
    /// the background, else the label with more voxels; none on a tie.
    Label through = Label{0};
    bool pairs = true;  ///< false: no neighbours across such a linel
};

/// Slots of the neighbour tables: -x +x -y +y -z +z. Slot s and s ^ 1 are opposite.
inline constexpr int kSlots = 6;

/// The digital surface of a label grid: all interfaces of all labels at once.
///
/// Pointel (x, y, z) is the low corner of voxel (x, y, z), so coordinates run from 0 to size.
/// Pointels are sorted by (z, y, x); after `splitUmbrellas` a place may have several of them, next
/// to each other. A surfel is named by its lowest corner and its axis: it lies
/// between the voxels `corner - e_axis` and `corner`; surfels are sorted by (z, y, x, axis).
struct DigitalSurface {
    IdVector<PointelId, Vec3i> pointels;
    /// The pointel one linel away, where that linel bounds a surfel. Symmetric: pointel q in slot s
    /// of p has p in slot s ^ 1.
    IdVector<PointelId, std::array<PointelId, kSlots>> neighbours;
    /// Surfels whose lowest corner is this pointel: the first of them, and which axes (bits 0-2).
    /// Empty after `splitUmbrellas`, which spreads the surfels of one place over several pointels.
    IdVector<PointelId, SurfelId> firstSurfel;
    IdVector<PointelId, std::uint8_t> surfelAxes;
    /// Slots whose linel is a junction linel (3 or more labels around it), as bits.
    IdVector<PointelId, std::uint8_t> junctionSlots;

    /// Counter-clockwise seen from the outer voxel, from the lowest corner.
    IdVector<SurfelId, std::array<PointelId, 4>> corners;
    IdVector<SurfelId, std::uint8_t> axis;
    /// 1 if the inner voxel is the low one (the normal goes +axis), 0 if it is the high one.
    IdVector<SurfelId, std::uint8_t> innerIsLow;
    IdVector<SurfelId, MaterialId> innerMaterial;
    IdVector<SurfelId, MaterialId> outerMaterial;
    IdVector<SurfelId, InterfaceId> interfaceOf;

    IdVector<InterfaceId, Interface> interfaces;  ///< sorted by label pair
    std::vector<SurfelId> byInterface;            ///< surfels grouped by interface, ascending

    /// Sides of a voxel; the shortest is 1, and lengths are measured in it.
    Vec3d spacing = Vec3d::Ones();
    /// Coordinates that may not move (bits 0-2), of pointels on the border of an open domain;
    /// empty where all may.
    IdVector<PointelId, std::uint8_t> fixedAxes;

    [[nodiscard]] std::size_t pointelCount() const { return pointels.size(); }
    [[nodiscard]] std::size_t surfelCount() const { return corners.size(); }
    /// Makes room in what is kept by surfel; `byInterface` is left alone.
    void resizeSurfels(std::size_t count) {
        corners.resize(count);
        axis.resize(count);
        innerIsLow.resize(count);
        innerMaterial.resize(count);
        outerMaterial.resize(count);
        interfaceOf.resize(count);
    }
    /// The surfel with this lowest corner and axis; kNone where there is none. Not after
    /// `splitUmbrellas`.
    [[nodiscard]] SurfelId surfelAt(PointelId lowest, int normalAxis) const {
        if (lowest == kNone<PointelId> || (surfelAxes[lowest] >> normalAxis & 1) == 0)
            return kNone<SurfelId>;
        const unsigned below = surfelAxes[lowest] & ((1U << normalAxis) - 1);
        return SurfelId{index(firstSurfel[lowest]) + (below & 1) + (below >> 1 & 1)};
    }
    /// The trivial normal: a unit lattice vector from the inner to the outer voxel.
    [[nodiscard]] Vec3i trivialNormal(SurfelId s) const {
        return Vec3i::Unit(axis[s]) * (innerIsLow[s] ? 1 : -1);
    }
    /// Where a pointel rests, in units of the shortest side of a voxel.
    [[nodiscard]] Vec3d position(PointelId p) const {
        return pointels[p].cast<double>().cwiseProduct(spacing);
    }
    /// The middle of a surfel, in units of the shortest side of a voxel.
    [[nodiscard]] Vec3d centre(SurfelId s) const {
        return 0.5 * doubleCentre(s).cast<double>().cwiseProduct(spacing);
    }
    /// Area of the surfels across an axis, in squares of the shortest side of a voxel.
    [[nodiscard]] double faceArea(int normalAxis) const {
        return spacing[(normalAxis + 1) % 3] * spacing[(normalAxis + 2) % 3];
    }
    /// Twice the centre on the lattice, so that it stays integer.
    [[nodiscard]] Vec3i doubleCentre(SurfelId s) const {
        return 2 * pointels[corners[s][0]] + Vec3i::Ones() - Vec3i::Unit(axis[s]);
    }
    [[nodiscard]] Vec3i innerVoxel(SurfelId s) const;
    [[nodiscard]] Vec3i outerVoxel(SurfelId s) const;
    /// A junction pointel ends or branches junction curves: the number of its junction linels is
    /// neither 0 nor 2.
    [[nodiscard]] bool isJunctionPointel(PointelId p) const {
        const int count = __builtin_popcount(junctionSlots[p]);
        return count != 0 && count != 2;
    }
};

/// How large the digital surface of a grid is, without building it.
struct SurfaceSize {
    std::uint64_t pointels = 0;
    std::uint64_t surfels = 0;
};

/// @errors cancelled
/// @cost   O(rows of bricks + stored voxels) time, 8 bytes per row of pointels
Result<SurfaceSize> countSurface(const VoxelGrid& grid, const RunContext& run);

/// Extracts all interfaces of a label grid: one surfel per pair of face-adjacent voxels whose
/// labels differ. Voxels outside the grid are background, so the surface of every label is closed;
/// with an open border there are none, and no surfel lies on the border.
///
/// @param grid  labels of the materials must be assigned; also gives `spacing`
/// @return      the same bits for any thread count
/// @errors      tooLarge if there are 2^32 - 1 surfels or pointels; cancelled
/// @cost        O(stored voxels + surfels) time, about 110 bytes per surfel
/// @source      [CGL18]; ours: a pointel exists where its 8 voxels do not all share one label, a
///              linel where its 4 voxels do not, so rows are scanned without any hash map
Result<DigitalSurface> extractSurface(const VoxelGrid& grid, const RunContext& run);

}  // namespace rivage::core
