#include "core/surface/row_scan.h"

#include <span>
#include <utility>

namespace rivage::core {
namespace {

/// Number of different labels among four, up to 3.
int distinct(Label a, Label b, Label c, Label d) {
    const int second = b != a;
    const int third = c != a && c != b;
    const int fourth = d != a && d != b && d != c;
    return 1 + second + third + fourth;
}

}  // namespace

RowScan::RowScan(const VoxelGrid& grid, const std::vector<bool>& storedRows)
    : grid_(grid), storedRows_(storedRows) {
    for (int row = 0; row < 4; ++row) {
        materials_[row].resize(grid.voxels.size().x() + 2);
        labels_[row].resize(grid.voxels.size().x() + 2);
    }
}

bool RowScan::isStored(int y, int z) const {
    const Vec3i& size = grid_.voxels.size();
    if (y < 0 || z < 0 || y >= size.y() || z >= size.z()) return false;
    const int side = BrickGrid::kSide;
    return storedRows_[static_cast<std::size_t>(z / side) * grid_.voxels.bricks().y() + y / side];
}

void RowScan::load(int row, int y, int z) {
    const bool stored = isStored(y, z);
    if (!stored && !any_[row]) return;  // empty before and after
    any_[row] = grid_.voxels.copyRow(-1, y, z, materials_[row]);
    for (std::size_t i = 0; i < materials_[row].size(); ++i)
        labels_[row][i] = grid_.materials[materials_[row][i]].label;
}

void RowScan::moveTo(int y, int z) {
    if (z == z_ && y == y_ + 1) {
        for (int low = lowYlowZ; low <= lowYhighZ; low += 2) {
            const int high = low + 1;
            std::swap(materials_[low], materials_[high]);
            std::swap(labels_[low], labels_[high]);
            std::swap(any_[low], any_[high]);
        }
    } else {
        load(lowYlowZ, y - 1, z - 1);
        load(lowYhighZ, y - 1, z);
    }
    load(highYlowZ, y, z - 1);
    load(highYhighZ, y, z);
    y_ = y;
    z_ = z;
}

RowScan::Linels RowScan::linelsAt(int x) const {
    const auto l = [&](Row row, int at) { return label(row, at); };
    // Around -x and +x: the four rows at one x. Around the others: two rows at both x.
    const std::array<int, 6> counts = {
        distinct(l(lowYlowZ, x - 1), l(highYlowZ, x - 1), l(lowYhighZ, x - 1),
                 l(highYhighZ, x - 1)),
        distinct(l(lowYlowZ, x), l(highYlowZ, x), l(lowYhighZ, x), l(highYhighZ, x)),
        distinct(l(lowYlowZ, x - 1), l(lowYlowZ, x), l(lowYhighZ, x - 1), l(lowYhighZ, x)),
        distinct(l(highYlowZ, x - 1), l(highYlowZ, x), l(highYhighZ, x - 1), l(highYhighZ, x)),
        distinct(l(lowYlowZ, x - 1), l(lowYlowZ, x), l(highYlowZ, x - 1), l(highYlowZ, x)),
        distinct(l(lowYhighZ, x - 1), l(lowYhighZ, x), l(highYhighZ, x - 1), l(highYhighZ, x))};
    Linels linels;
    for (int slot = 0; slot < 6; ++slot) {
        linels.present |= static_cast<std::uint8_t>((counts[slot] > 1) << slot);
        linels.junction |= static_cast<std::uint8_t>((counts[slot] > 2) << slot);
    }
    return linels;
}

std::uint8_t RowScan::surfelAxesAt(int x) const {
    const Label high = label(highYhighZ, x);
    const int alongX = label(highYhighZ, x - 1) != high;
    const int alongY = label(lowYhighZ, x) != high;
    const int alongZ = label(highYlowZ, x) != high;
    return static_cast<std::uint8_t>(alongX | alongY << 1 | alongZ << 2);
}

}  // namespace rivage::core
