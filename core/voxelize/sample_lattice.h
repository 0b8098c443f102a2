#pragma once

#include <cstdint>

#include "core/base/vec.h"

namespace rivage::core {

__extension__ using Int128 = __int128;

/// Fixed-point units of a voxel: positions are snapped to this grid before anything is sampled.
inline constexpr std::int64_t kUnitsPerVoxel = 4096;

/// A box of sample points at `up / down` samples a voxel along each axis. Sample j of an axis is
/// the centre of the cube [j, j + 1] * down / up, in voxels of the input.
struct SampleLattice {
    int up = 1;
    int down = 1;
    Vec3i size = Vec3i::Zero();  ///< samples along x, y, z

    /// As many samples as cover a grid: the last may lie outside it.
    /// @param grid  voxels along x, y, z
    [[nodiscard]] static SampleLattice over(const Vec3i& grid, int up, int down) {
        return {up, down, (grid * up + Vec3i::Constant(down - 1)) / down};
    }
    /// Fixed-point units between two samples of an axis; one is 1 / (`kUnitsPerVoxel` * up) voxel,
    /// in which every sample and every snapped position is whole.
    [[nodiscard]] std::int64_t step() const { return kUnitsPerVoxel * down; }
    [[nodiscard]] std::int64_t at(int sample) const {
        return kUnitsPerVoxel / 2 * down * (2 * std::int64_t{sample} + 1);
    }
    /// The first sample that is not before a coordinate in the units of `at`; may be outside.
    [[nodiscard]] std::int64_t firstFrom(std::int64_t coordinate) const {
        const std::int64_t ahead = coordinate - at(0);
        return ahead <= 0 ? -(-ahead / step()) : (ahead + step() - 1) / step();
    }
    /// The voxel of the input that holds a sample; the higher one where it lies between two.
    [[nodiscard]] int voxelOf(int sample) const {
        return static_cast<int>((2 * std::int64_t{sample} + 1) * down / (2 * up));
    }
    [[nodiscard]] Vec3i voxelOf(const Vec3i& sample) const {
        return {voxelOf(sample.x()), voxelOf(sample.y()), voxelOf(sample.z())};
    }
    /// Where a sample lies, in voxels of the input.
    [[nodiscard]] Vec3d position(const Vec3i& sample) const {
        return (sample.cast<double>().array() + 0.5) * down / up;
    }
};

}  // namespace rivage::core
