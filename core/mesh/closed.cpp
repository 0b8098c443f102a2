#include "core/mesh/closed.h"

#include <array>

namespace rivage::core {
namespace {

// The surfels around one linel; those in use stand first.
struct LinelSurfels {
    std::array<SurfelId, 4> items{};
    int count = 0;
};

// The surfels that contain the linel from pointel `low` along +`axis`.
LinelSurfels surfelsAround(const DigitalSurface& surface, PointelId low, int axis) {
    LinelSurfels around;
    for (int step = 1; step <= 2; ++step) {
        const int span = (axis + step) % 3;  // a surfel around the linel spans `axis` and this one
        const PointelId below = surface.neighbours[low][2 * span];
        for (const PointelId lowest : {low, below}) {
            const SurfelId s = surface.surfelAt(lowest, 3 - axis - span);
            if (s != kNone<SurfelId>) around.items[around.count++] = s;
        }
    }
    return around;
}

// Marks the labels that have an odd number of surfels among these.
void checkLinel(const DigitalSurface& surface, const LinelSurfels& around,
                std::vector<bool>& closed) {
    std::array<Label, 8> sides{};
    int count = 0;
    for (int i = 0; i < around.count; ++i) {
        const LabelPair& labels = surface.interfaces[surface.interfaceOf[around.items[i]]].labels;
        sides[count++] = labels.inner;
        sides[count++] = labels.outer;
    }
    for (int i = 0; i < count; ++i) {
        if (sides[i] == Label{0}) continue;
        int times = 0;
        for (int j = 0; j < count; ++j) times += sides[j] == sides[i] ? 1 : 0;
        if (times % 2 != 0) closed[index(sides[i]) - 1] = false;
    }
}

}  // namespace

std::vector<bool> closedLabels(const VoxelGrid& grid, const DigitalSurface& surface) {
    std::vector<bool> closed(grid.labels.size() - 1, true);
    std::size_t sides = 0;
    for (std::uint32_t i = 0; i < surface.pointelCount(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const PointelId low{i};
            if (surface.neighbours[low][2 * axis + 1] == kNone<PointelId>) continue;
            const LinelSurfels around = surfelsAround(surface, low, axis);
            sides += static_cast<std::size_t>(around.count);
            checkLinel(surface, around, closed);
        }
    // A face with a side on no linel would have gone unseen.
    if (sides != 4 * surface.surfelCount()) closed.assign(closed.size(), false);
    return closed;
}

}  // namespace rivage::core
