#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/base/vec.h"

namespace rivage::core {

/// A dense box of material ids that is stored in bricks of 16^3 voxels; a brick that holds only
/// empty voxels takes 4 bytes. Voxel (x, y, z) is the unit cube [x,x+1]*[y,y+1]*[z,z+1].
class BrickGrid {
public:
    static constexpr int kSide = 16;
    static constexpr std::size_t kBrickVoxels = std::size_t{kSide} * kSide * kSide;
    using Brick = std::array<MaterialId, kBrickVoxels>;  ///< x fastest, then y, then z

    BrickGrid() = default;
    /// @cost 4 bytes per brick; no voxel is stored yet
    explicit BrickGrid(const Vec3i& size);
    /// With bricks of empty voxels where `stored` says so (x fastest), to be filled by several
    /// threads at once.
    /// @param stored  one flag a brick
    BrickGrid(const Vec3i& size, const std::vector<bool>& stored);

    [[nodiscard]] const Vec3i& size() const { return size_; }
    /// Number of bricks along x, y, z.
    [[nodiscard]] const Vec3i& bricks() const { return bricks_; }
    [[nodiscard]] bool contains(const Vec3i& voxel) const {
        return (voxel.array() >= 0).all() && (voxel.array() < size_.array()).all();
    }
    /// The material of a voxel; empty outside the grid.
    [[nodiscard]] MaterialId at(const Vec3i& voxel) const;
    /// Sets a voxel inside the grid; allocates its brick if `material` is not empty.
    void set(const Vec3i& voxel, MaterialId material);
    /// The brick with these brick coordinates, or null where all its voxels are empty.
    [[nodiscard]] const Brick* brick(const Vec3i& at) const;
    [[nodiscard]] Brick* brick(const Vec3i& at);
    /// Copies the voxels (xBegin, y, z), (xBegin + 1, y, z), ... into `row`; empty outside.
    /// @return false if every voxel copied is empty because no brick is stored there
    bool copyRow(int xBegin, int y, int z, std::span<MaterialId> row) const;
    /// Calls `visit(voxel, material)` for every voxel that is not empty, brick by brick.
    template <typename Visit>
    void forEach(Visit&& visit) const {
        forEachUntil([] { return false; }, visit);
    }
    /// As `forEach`; asks `stopped()` every few bricks.
    /// @return false if it said yes; some voxels were then not visited
    template <typename Stopped, typename Visit>
    bool forEachUntil(Stopped&& stopped, Visit&& visit) const;
    /// For each row of bricks along x, y fastest, then z: whether it stores a brick.
    /// @cost O(bricks)
    [[nodiscard]] std::vector<bool> storedRows() const;
    [[nodiscard]] std::uint64_t countVoxels() const;
    [[nodiscard]] std::size_t memoryBytes() const;
    /// Rewrites every stored material id through `map` (map[0] must be 0).
    void remap(std::span<const MaterialId> map);

private:
    [[nodiscard]] std::size_t slot(const Vec3i& brick) const;

    Vec3i size_ = Vec3i::Zero();
    Vec3i bricks_ = Vec3i::Zero();
    std::vector<std::uint32_t> directory_;  // 0: empty, otherwise 1 + index into store_
    std::vector<Brick> store_;
};

template <typename Stopped, typename Visit>
bool BrickGrid::forEachUntil(Stopped&& stopped, Visit&& visit) const {
    constexpr std::size_t kPoll = 16;  // bricks
    for (std::size_t s = 0; s < directory_.size(); ++s) {
        if (s % kPoll == 0 && stopped()) return false;
        if (directory_[s] == 0) continue;
        const Brick& brick = store_[directory_[s] - 1];
        const auto bx = static_cast<int>(s % bricks_.x());
        const auto by = static_cast<int>(s / bricks_.x() % bricks_.y());
        const auto bz = static_cast<int>(s / bricks_.x() / bricks_.y());
        const Vec3i base = Vec3i(bx, by, bz) * kSide;
        for (std::size_t i = 0; i < kBrickVoxels; ++i)
            if (brick[i] != MaterialId{0})
                visit(Vec3i(base + Vec3i(static_cast<int>(i % kSide),
                                         static_cast<int>(i / kSide % kSide),
                                         static_cast<int>(i / kSide / kSide))),
                      brick[i]);
    }
    return true;
}

}  // namespace rivage::core
