#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/grid/voxel_grid.h"

/// Label grids for tests: small, seeded, and written down as what they mean.
namespace rivage::test {

using namespace rivage::core;

/// A grid whose material ids are the labels 0 .. labelCount.
template <typename LabelAt>
VoxelGrid makeGrid(const Vec3i& size, int labelCount, LabelAt&& labelAt) {
    VoxelGrid grid;
    grid.voxels = BrickGrid(size);
    grid.materials.resize(labelCount + 1);
    grid.labels.resize(labelCount + 1);
    for (int l = 1; l <= labelCount; ++l) {
        grid.materials.raw()[l].label = static_cast<Label>(l);
        grid.materials.raw()[l].source = static_cast<std::uint32_t>(l);
        grid.labels.raw()[l] = "label " + std::to_string(l);
    }
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x) {
                const int label = labelAt(Vec3i(x, y, z));
                grid.voxels.set({x, y, z}, static_cast<MaterialId>(label));
            }
    return grid;
}

/// Independent random labels: every local configuration of labels occurs.
inline VoxelGrid randomGrid(std::uint32_t seed, const Vec3i& size, int labelCount) {
    std::mt19937 random(seed);
    return makeGrid(size, labelCount, [&](const Vec3i&) {
        return static_cast<int>(random() % static_cast<std::uint32_t>(labelCount + 1));
    });
}

/// Voxels whose centre is within `radius` of the centre of a grid of side^3.
inline VoxelGrid ballGrid(int side, double radius, const Vec3d& shift = Vec3d::Zero()) {
    const Vec3d centre = Vec3d::Constant(side / 2.0) + shift;
    return makeGrid(Vec3i::Constant(side), 1, [&](const Vec3i& v) {
        return (v.cast<double>() + Vec3d::Constant(0.5) - centre).norm() <= radius;
    });
}

/// How `sectorGrid` cuts a ball: half-planes through a tilted axis, at equal turns about it.
struct SectorFrame {
    Vec3d centre;
    Vec3d axis = Vec3d(0.3, 0.2, 1).normalized();
    Vec3d u = axis.cross(Vec3d(1, 0.1, 0)).normalized();  ///< turn 1/2, w is turn 3/4
    Vec3d w = axis.cross(u);
    explicit SectorFrame(int side)
        : centre(Vec3d::Constant(side / 2.0) + Vec3d(0.17, -0.08, 0.21)) {}
    /// The label, 1 to `sectors`, of a point at `p` from the centre.
    [[nodiscard]] int labelOf(const Vec3d& p, int sectors) const {
        const double turn = std::atan2(p.dot(w), p.dot(u)) / (2 * M_PI) + 0.5;
        return 1 + static_cast<int>(turn * sectors) % sectors;
    }
};

/// A ball cut into `sectors` labels by half-planes through a tilted axis.
inline VoxelGrid sectorGrid(int side, double radius, int sectors = 3) {
    const SectorFrame frame(side);
    return makeGrid(Vec3i::Constant(side), sectors, [&](const Vec3i& v) {
        const Vec3d p = v.cast<double>() + Vec3d::Constant(0.5) - frame.centre;
        return p.norm() > radius ? 0 : frame.labelOf(p, sectors);
    });
}

/// Flips voxels of a grid from `makeGrid` to the label of the nearest voxel of another label with
/// the probability p^d, where d >= 1 is the distance to it in steps (Kanungo's noise model).
inline VoxelGrid withLabelNoise(const VoxelGrid& grid, double p, std::uint32_t seed) {
    constexpr int kReach = 4;
    std::mt19937 random(seed);
    VoxelGrid noisy = grid;
    const Vec3i& size = grid.voxels.size();
    // The distance is tried ring by ring; ties go to the first in lattice order.
    const auto nearestOther = [&](const Vec3i& v, int distance) -> std::optional<Label> {
        for (int dz = -distance; dz <= distance; ++dz)
            for (int dy = -distance; dy <= distance; ++dy)
                for (int dx = -distance; dx <= distance; ++dx) {
                    if (std::abs(dx) + std::abs(dy) + std::abs(dz) != distance) continue;
                    const Label label = grid.labelAt(v + Vec3i(dx, dy, dz));
                    if (label != grid.labelAt(v)) return label;
                }
        return std::nullopt;
    };
    for (int z = 1; z < size.z() - 1; ++z)
        for (int y = 1; y < size.y() - 1; ++y)
            for (int x = 1; x < size.x() - 1; ++x) {
                const Vec3i v(x, y, z);
                const double draw = static_cast<double>(random()) / 4294967296.0;
                for (int distance = 1; distance <= kReach; ++distance) {
                    const auto other = nearestOther(v, distance);
                    if (!other) continue;
                    if (draw < std::pow(p, distance))
                        noisy.voxels.set(v, static_cast<MaterialId>(index(*other)));
                    break;
                }
            }
    return noisy;
}

/// One of the 48 symmetries of the cube: a signed permutation of the axes.
struct Symmetry {
    Mat3i matrix;
    [[nodiscard]] int determinant() const {
        return static_cast<int>(std::lround(matrix.cast<double>().determinant()));
    }
    /// Maps a pointel of a grid of this size.
    [[nodiscard]] Vec3d point(const Vec3d& p, const Vec3i& size) const {
        const Vec3d half = size.cast<double>() / 2;
        const Mat3d m = matrix.cast<double>();
        return m * (p - half) + (m.cwiseAbs() * half);
    }
    [[nodiscard]] Vec3i size(const Vec3i& s) const { return matrix.cwiseAbs() * s; }
};

inline std::vector<Symmetry> cubeSymmetries() {
    std::vector<Symmetry> all;
    const int permutations[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                    {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (const auto& permutation : permutations)
        for (int signs = 0; signs < 8; ++signs) {
            Mat3i matrix = Mat3i::Zero();
            for (int row = 0; row < 3; ++row)
                matrix(row, permutation[row]) = (signs >> row & 1) != 0 ? -1 : 1;
            all.push_back({matrix});
        }
    return all;
}

inline VoxelGrid transformed(const VoxelGrid& grid, const Symmetry& symmetry) {
    VoxelGrid result = grid;
    result.voxels = BrickGrid(symmetry.size(grid.voxels.size()));
    grid.voxels.forEach([&](const Vec3i& voxel, MaterialId material) {
        const Vec3d centre = voxel.cast<double>() + Vec3d::Constant(0.5);
        const Vec3d moved = symmetry.point(centre, grid.voxels.size());
        result.voxels.set(moved.array().floor().matrix().cast<int>(), material);
    });
    return result;
}

}  // namespace rivage::test
