#include "core/grid/brick_grid.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace rivage::core {
namespace {

constexpr int kSide = BrickGrid::kSide;

std::size_t cellInBrick(const Vec3i& voxel) {
    return static_cast<std::size_t>(voxel.x() % kSide +
                                    kSide * (voxel.y() % kSide + kSide * (voxel.z() % kSide)));
}

}  // namespace

BrickGrid::BrickGrid(const Vec3i& size)
    : size_(size), bricks_((size.array() + (kSide - 1)) / kSide) {
    assert((size.array() >= 0).all());
    directory_.assign(static_cast<std::size_t>(bricks_.x()) * bricks_.y() * bricks_.z(), 0);
}

BrickGrid::BrickGrid(const Vec3i& size, const std::vector<bool>& stored) : BrickGrid(size) {
    assert(stored.size() == directory_.size());
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < stored.size(); ++i)
        if (stored[i]) directory_[i] = ++count;
    store_.resize(count);  // value-initialized: empty
}

std::size_t BrickGrid::slot(const Vec3i& brick) const {
    return brick.x() + static_cast<std::size_t>(bricks_.x()) *
                           (brick.y() + static_cast<std::size_t>(bricks_.y()) * brick.z());
}

MaterialId BrickGrid::at(const Vec3i& voxel) const {
    if (!contains(voxel)) return MaterialId{0};
    const std::uint32_t entry = directory_[slot(voxel / kSide)];
    return entry == 0 ? MaterialId{0} : store_[entry - 1][cellInBrick(voxel)];
}

void BrickGrid::set(const Vec3i& voxel, MaterialId material) {
    assert(contains(voxel));
    std::uint32_t& entry = directory_[slot(voxel / kSide)];
    if (entry == 0) {
        if (material == MaterialId{0}) return;
        store_.emplace_back().fill(MaterialId{0});
        entry = static_cast<std::uint32_t>(store_.size());
    }
    store_[entry - 1][cellInBrick(voxel)] = material;
}

const BrickGrid::Brick* BrickGrid::brick(const Vec3i& at) const {
    if ((at.array() < 0).any() || (at.array() >= bricks_.array()).any()) return nullptr;
    const std::uint32_t entry = directory_[slot(at)];
    return entry == 0 ? nullptr : &store_[entry - 1];
}

BrickGrid::Brick* BrickGrid::brick(const Vec3i& at) {
    return const_cast<Brick*>(std::as_const(*this).brick(at));
}

bool BrickGrid::copyRow(int xBegin, int y, int z, std::span<MaterialId> row) const {
    std::fill(row.begin(), row.end(), MaterialId{0});
    if (y < 0 || z < 0 || y >= size_.y() || z >= size_.z()) return false;
    const int xEnd = std::min(xBegin + static_cast<int>(row.size()), size_.x());
    const std::size_t first = slot(Vec3i(0, y / kSide, z / kSide));
    bool any = false;
    for (int x = std::max(xBegin, 0); x < xEnd;) {
        const int brickEnd = std::min((x / kSide + 1) * kSide, xEnd);
        if (const std::uint32_t entry = directory_[first + x / kSide]; entry != 0) {
            const MaterialId* cells = &store_[entry - 1][cellInBrick(Vec3i(x, y, z))];
            std::copy(cells, cells + (brickEnd - x), row.begin() + (x - xBegin));
            any = true;
        }
        x = brickEnd;
    }
    return any;
}

std::vector<bool> BrickGrid::storedRows() const {
    std::vector<bool> stored(static_cast<std::size_t>(bricks_.y()) * bricks_.z());
    for (std::size_t row = 0; row < stored.size(); ++row) {
        const auto first = directory_.begin() + static_cast<std::ptrdiff_t>(row * bricks_.x());
        stored[row] =
            std::any_of(first, first + bricks_.x(), [](auto entry) { return entry != 0; });
    }
    return stored;
}

std::uint64_t BrickGrid::countVoxels() const {
    std::uint64_t count = 0;
    for (const Brick& brick : store_)
        count += kBrickVoxels -
                 static_cast<std::uint64_t>(std::count(brick.begin(), brick.end(), MaterialId{0}));
    return count;
}

std::size_t BrickGrid::memoryBytes() const {
    return store_.capacity() * sizeof(Brick) + directory_.capacity() * sizeof(std::uint32_t);
}

void BrickGrid::remap(std::span<const MaterialId> map) {
    assert(!map.empty() && map[0] == MaterialId{0});
    for (Brick& brick : store_)
        for (MaterialId& material : brick) material = map[index(material)];
}

}  // namespace rivage::core
