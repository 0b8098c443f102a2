#pragma once

#include <memory>
#include <utility>

#include "core/voxelize/label_columns.h"
#include "core/voxelize/resample.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace rivage::test {

/// A surface whose pointels have moved, with what is needed to sample it.
struct Sampled {
    VoxelGrid grid;
    std::unique_ptr<DigitalSurface> surface;
    std::unique_ptr<Positions> positions;
    std::unique_ptr<MovedSurface> moved;
    std::unique_ptr<NearestSurfel> nearest;

    Sampled(VoxelGrid voxels, DigitalSurface made, Positions places)
        : grid(std::move(voxels)),
          surface(std::make_unique<DigitalSurface>(std::move(made))),
          positions(std::make_unique<Positions>(std::move(places))),
          moved(std::make_unique<MovedSurface>(*snapSurface(*surface, *positions, {}))),
          nearest(std::make_unique<NearestSurfel>(
              *NearestSurfel::build(*moved, grid.voxels.size(), {}))) {}

    [[nodiscard]] LabelColumns scan(int up, int down = 1, int threads = 1) const {
        const auto lattice = SampleLattice::over(grid.voxels.size(), up, down);
        return *scanLabels(grid, *moved, *nearest, lattice, {.threads = threads});
    }
    [[nodiscard]] VoxelGrid resampled(int up, int down = 1, int threads = 1) const {
        return *resample(grid, *nearest, scan(up, down, threads), {.threads = threads});
    }
};

/// The surface with its umbrellas split, each pointel moved by up to `amplitude` along each axis;
/// on an open border it keeps to the border.
inline Sampled moved(VoxelGrid grid, double amplitude, std::uint32_t seed = 1) {
    DigitalSurface surface = splitSurface(grid);
    Positions positions = movedPositions(surface, amplitude, seed);
    for (std::uint32_t i = 0; i < surface.fixedAxes.size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
            if (surface.fixedAxes[PointelId{i}] >> axis & 1)
                positions[PointelId{i}][axis] = surface.position(PointelId{i})[axis];
    return {std::move(grid), std::move(surface), std::move(positions)};
}

/// The material of every voxel of a grid whose centre is also a sample at an odd number of samples
/// a voxel: undoes the upsampling.
inline BrickGrid decimated(const BrickGrid& fine, int factor) {
    BrickGrid coarse(fine.size() / factor);
    const Vec3i middle = Vec3i::Constant(factor / 2);
    for (int z = 0; z < coarse.size().z(); ++z)
        for (int y = 0; y < coarse.size().y(); ++y)
            for (int x = 0; x < coarse.size().x(); ++x)
                coarse.set({x, y, z}, fine.at(Vec3i(x, y, z) * factor + middle));
    return coarse;
}

inline bool sameVoxels(const BrickGrid& a, const BrickGrid& b) {
    if (a.size() != b.size()) return false;
    for (int z = 0; z < a.size().z(); ++z)
        for (int y = 0; y < a.size().y(); ++y)
            for (int x = 0; x < a.size().x(); ++x)
                if (a.at({x, y, z}) != b.at({x, y, z})) return false;
    return true;
}

}  // namespace rivage::test
