#include "core/surface/row_scan.h"

#include <algorithm>
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

int RowScan::inside(int y, int axis) const {
    return grid_.openBorder ? std::clamp(y, 0, grid_.voxels.size()[axis] - 1) : y;
}

void RowScan::load(int row, int outerY, int outerZ) {
    const int y = inside(outerY, 1);
    const int z = inside(outerZ, 2);
    const bool stored = isStored(y, z);
    if (!stored && !any_[row]) return;  // empty before and after
    std::vector<MaterialId>& voxels = materials_[row];
    any_[row] = grid_.voxels.copyRow(-1, y, z, voxels);
    if (grid_.openBorder) {
        voxels.front() = voxels[1];
        voxels.back() = voxels[voxels.size() - 2];
    }
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
    if (grid_.openBorder) {
        const unsigned there = slotsInside(x);
        linels.present &= static_cast<std::uint8_t>(there);
        linels.junction &= static_cast<std::uint8_t>(there);
    }
    return linels;
}

std::uint8_t RowScan::surfelAxesAt(int x) const {
    const Label high = label(highYhighZ, x);
    const int alongX = label(highYhighZ, x - 1) != high;
    const int alongY = label(lowYhighZ, x) != high;
    const int alongZ = label(highYlowZ, x) != high;
    const auto axes = static_cast<std::uint8_t>(alongX | alongY << 1 | alongZ << 2);
    if (!grid_.openBorder) return axes;
    // A surfel runs towards +u and +v of the two axes that it spans.
    constexpr std::array<unsigned, 3> kSpans = {0b101000, 0b100010, 0b001010};
    std::uint8_t kept = 0;
    for (int axis = 0; axis < 3; ++axis)
        if ((slotsInside(x) & kSpans[axis]) == kSpans[axis])
            kept |= static_cast<std::uint8_t>(axes & 1U << axis);
    return kept;
}

unsigned RowScan::slotsInside(int x) const {
    const Vec3i at(x, y_, z_);
    unsigned slots = 0;
    for (int axis = 0; axis < 3; ++axis) {
        slots |= (at[axis] > 0 ? 1U : 0U) << (2 * axis);
        slots |= (at[axis] < grid_.voxels.size()[axis] ? 1U : 0U) << (2 * axis + 1);
    }
    return slots;
}

std::uint8_t RowScan::fixedAxesAt(int x) const {
    const unsigned outside = ~slotsInside(x);
    unsigned axes = 0;
    for (int axis = 0; axis < 3; ++axis)
        axes |= ((outside >> 2 * axis & 3U) != 0 ? 1U : 0U) << axis;
    return static_cast<std::uint8_t>(axes);
}

}  // namespace rivage::core
