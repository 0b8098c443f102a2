#include "tests/support/voxel_centres.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace rivage::test {
namespace {

/// Where the ray of a column crosses a face. Going down through it, `from` ends and `to` begins.
struct Crossing {
    double z;
    Label from;
    Label to;
};

/// Twice the signed area of (a, b, p) seen from above; never 0: a point on an edge counts as left
/// of the edge from the lower to the higher vertex, in both triangles that share it.
double sideOf(const PointelVectors& x, PointelId a, PointelId b, double px, double py) {
    const bool ordered = a < b;
    const Vec3d& low = x[ordered ? a : b];
    const Vec3d& high = x[ordered ? b : a];
    double side = (high.x() - low.x()) * (py - low.y()) - (high.y() - low.y()) * (px - low.x());
    if (side == 0) side = 1e-300;
    return ordered ? side : -side;
}

class Columns {
public:
    Columns(const VoxelGrid& grid, const PointelVectors& positions)
        : size_(grid.voxels.size() + Vec3i::Constant(2)),
          positions_(positions),
          columns_(static_cast<std::size_t>(size_.x()) * size_.y()) {}

    void add(PointelId a, PointelId b, PointelId c, LabelPair labels) {
        const Vec3d& pa = positions_[a];
        const Vec3d& pb = positions_[b];
        const Vec3d& pc = positions_[c];
        const Vec3d low = pa.cwiseMin(pb).cwiseMin(pc);
        const Vec3d high = pa.cwiseMax(pb).cwiseMax(pc);
        for (int y = columnAbove(low.y()); y < size_.y() && y - 0.5 <= high.y(); ++y)
            for (int x = columnAbove(low.x()); x < size_.x() && x - 0.5 <= high.x(); ++x) {
                const double px = x - 0.5;
                const double py = y - 0.5;
                const double wa = sideOf(positions_, b, c, px, py);
                const double wb = sideOf(positions_, c, a, px, py);
                const double wc = sideOf(positions_, a, b, px, py);
                const bool up = wa > 0 && wb > 0 && wc > 0;
                const bool down = wa < 0 && wb < 0 && wc < 0;
                if (!up && !down) continue;
                const double z = (wa * pa.z() + wb * pb.z() + wc * pc.z()) / (wa + wb + wc);
                // A face that is seen from above has its outer label above.
                at(x, y).push_back(up ? Crossing{z, labels.outer, labels.inner}
                                      : Crossing{z, labels.inner, labels.outer});
            }
    }

    std::size_t countWrong(const VoxelGrid& grid) {
        std::size_t wrong = 0;
        for (int y = 0; y < size_.y(); ++y)
            for (int x = 0; x < size_.x(); ++x) {
                auto& crossings = at(x, y);
                std::sort(crossings.begin(), crossings.end(),
                          [](const Crossing& a, const Crossing& b) { return a.z > b.z; });
                std::map<Label, int> winding{{Label{0}, 1}};
                auto next = crossings.begin();
                for (int z = size_.z() - 1; z >= 0; --z) {
                    for (; next != crossings.end() && next->z > z - 0.5; ++next) {
                        --winding[next->from];
                        ++winding[next->to];
                    }
                    const Label expected = grid.labelAt(Vec3i(x, y, z) - Vec3i::Ones());
                    wrong += !std::all_of(winding.begin(), winding.end(), [&](const auto& entry) {
                        return entry.second == (entry.first == expected ? 1 : 0);
                    });
                }
            }
        return wrong;
    }

private:
    // Column i holds the voxels i - 1, whose centres are at i - 0.5.
    static int columnAbove(double at) { return std::max(0, static_cast<int>(std::ceil(at + 0.5))); }
    std::vector<Crossing>& at(int x, int y) {
        return columns_[static_cast<std::size_t>(y) * size_.x() + x];
    }

    Vec3i size_;
    const PointelVectors& positions_;
    std::vector<std::vector<Crossing>> columns_;
};

}  // namespace

std::size_t countWrongCentres(const VoxelGrid& grid, const DigitalSurface& surface,
                              const PointelVectors& positions) {
    Columns columns(grid, positions);
    for (std::size_t f = 0; f < surface.surfelCount(); ++f) {
        const SurfelId s{static_cast<std::uint32_t>(f)};
        const auto& c = surface.corners[s];
        const LabelPair labels = surface.interfaces[surface.interfaceOf[s]].labels;
        columns.add(c[0], c[1], c[2], labels);
        columns.add(c[0], c[2], c[3], labels);
    }
    return columns.countWrong(grid);
}

}  // namespace rivage::test
