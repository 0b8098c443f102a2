#pragma once

#include <cstdint>

#include "core/mesh/build_mesh.h"
#include "core/surface/digital_surface.h"
#include "core/surface/split_umbrellas.h"
#include "tests/support/grids.h"

/// Surfaces and positions for the tests of meshes and writers.
namespace rivage::test {

using Positions = IdVector<PointelId, Vec3d>;

/// The surface of a grid with its umbrellas split.
inline DigitalSurface splitSurface(const VoxelGrid& grid) {
    DigitalSurface surface = *extractSurface(grid, {});
    const SurfelLinks links = *linkSurfels(surface, {});
    (void)*splitUmbrellas(surface, links, {});
    return surface;
}

/// The pointels where they lie on the lattice.
inline Positions latticePositions(const DigitalSurface& surface) {
    Positions positions(surface.pointelCount());
    for (std::uint32_t i = 0; i < positions.size(); ++i)
        positions[PointelId{i}] = surface.position(PointelId{i});
    return positions;
}

/// The pointels, each moved by up to `amplitude` along each axis.
inline Positions movedPositions(const DigitalSurface& surface, double amplitude,
                                std::uint32_t seed = 1) {
    std::mt19937 random(seed);
    Positions positions = latticePositions(surface);
    for (Vec3d& position : positions)
        for (int axis = 0; axis < 3; ++axis) {
            const double unit = static_cast<double>(random()) / 4294967295.0;
            position[axis] += amplitude * (2 * unit - 1);
        }
    return positions;
}

/// Gives every material its own colour.
inline VoxelGrid colored(VoxelGrid grid) {
    for (std::uint32_t i = 1; i < grid.materials.size(); ++i)
        grid.materials[static_cast<MaterialId>(i)].color = {
            static_cast<std::uint8_t>(40 * i + 3), static_cast<std::uint8_t>(255 - 30 * i),
            static_cast<std::uint8_t>(90 + 17 * i), 255};
    return grid;
}

/// Two labels: a flat sea (1) and a hill (2) that rises out of it, with a shared shore line.
inline VoxelGrid islandGrid(int side = 16) {
    return colored(makeGrid({side, side, side / 2}, 2, [&](const Vec3i& v) {
        const Vec3d centre(side / 2.0, side / 2.0, 0);
        const double reach = (v.cast<double>() + Vec3d::Constant(0.5) - centre).norm();
        if (reach < side / 3.0) return 2;
        return v.z() < side / 6 ? 1 : 0;
    }));
}

struct Built {
    VoxelGrid grid;
    DigitalSurface surface;
    Positions positions;
    Mesh mesh;
};

/// The mesh of a grid whose pointels have moved by up to `amplitude`.
inline Built build(VoxelGrid grid, const OutputOptions& options = {}, double amplitude = 0,
                   int threads = 1) {
    Built built{.grid = std::move(grid)};
    built.surface = *extractSurface(built.grid, {});
    built.positions = movedPositions(built.surface, amplitude);
    built.mesh = *buildMesh(built.grid, built.surface, *linkSurfels(built.surface, {}),
                            built.positions, options, {.threads = threads});
    return built;
}

}  // namespace rivage::test
