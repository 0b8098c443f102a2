#include "core/voxelize/coarse_colors.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/base/parallel.h"
#include "core/grid/oklab.h"

namespace rivage::core {
namespace {

constexpr double kNear = 0.05;  // shades of one paint; twice to three times what people can tell

/// Samples by material; a handful of materials.
class Tally {
public:
    void add(MaterialId material) {
        for (auto& [id, count] : counts_)
            if (id == material) {
                ++count;
                return;
            }
        counts_.emplace_back(material, 1);
    }
    [[nodiscard]] bool empty() const { return counts_.empty(); }

    /// @param colors  OKLab, by material
    MaterialId mode(const std::vector<Vec3d>& colors) {
        std::sort(counts_.begin(), counts_.end());
        std::pair<int, int> best{0, 0};
        MaterialId winner{0};
        for (const auto& [id, count] : counts_) {
            int near = 0;
            for (const auto& [other, more] : counts_)
                if ((colors[index(id)] - colors[index(other)]).norm() <= kNear) near += more;
            if (std::pair(near, count) <= best) continue;
            best = {near, count};
            winner = id;
        }
        return winner;
    }

private:
    std::vector<std::pair<MaterialId, int>> counts_;
};

/// Tells the material of one voxel after another.
class Colorist {
public:
    Colorist(const VoxelGrid& grid, const SampleMaterials& materials, const LabelColumns& columns,
             int each, const VoxelGrid& coarse, const std::vector<Vec3d>& colors)
        : grid_(grid),
          materials_(materials),
          columns_(columns),
          each_(each),
          coarse_(coarse),
          colors_(colors),
          inside_(static_cast<std::size_t>(each) * each * each) {}

    MaterialId materialOf(const Vec3i& voxel, Label label) {
        low_ = voxel * each_;
        label_ = label;
        markSamples();
        Tally tally;
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {-1, 1})
                if (coarse_.labelAt(voxel + side * Vec3i::Unit(axis)) != label)
                    lookThrough(axis, side, tally);
        if (tally.empty()) lookAtAll(tally);
        if (!tally.empty()) return tally.mode(colors_);
        const Vec3i middle = low_ + Vec3i::Constant(each_ / 2);
        return materials_.nearestOf(label, columns_.lattice().position(middle));
    }

private:
    /// Which samples of the voxel have its label, x fastest.
    void markSamples() {
        std::fill(inside_.begin(), inside_.end(), false);
        for (int y = 0; y < each_; ++y)
            for (int x = 0; x < each_; ++x) {
                const auto column = columns_.column(low_.x() + x, low_.y() + y);
                for (std::size_t i = 0; i < column.size(); ++i) {
                    const int end =
                        i + 1 < column.size() ? column[i + 1].begin : columns_.lattice().size.z();
                    if (column[i].label != label_) continue;
                    const int to = std::min(end - low_.z(), each_);
                    for (int z = std::max(column[i].begin - low_.z(), 0); z < to; ++z)
                        inside_[place({x, y, z})] = true;
                }
            }
    }
    [[nodiscard]] std::size_t place(const Vec3i& at) const {
        return at.x() + static_cast<std::size_t>(each_) * (at.y() + std::size_t(each_) * at.z());
    }
    /// The material of a sample, empty where its voxel has another label.
    [[nodiscard]] MaterialId heldAt(const Vec3i& at) const {
        if (!inside_[place(at)]) return MaterialId{0};
        const MaterialId held = grid_.voxels.at(columns_.lattice().voxelOf(Vec3i(low_ + at)));
        return grid_.materials[held].label == label_ ? held : MaterialId{0};
    }
    /// Counts the first sample on each line that enters the voxel through one of its faces.
    void lookThrough(int axis, int side, Tally& tally) const {
        const Vec3i u = Vec3i::Unit((axis + 1) % 3);
        const Vec3i v = Vec3i::Unit((axis + 2) % 3);
        const Vec3i start =
            side < 0 ? Vec3i(Vec3i::Zero()) : Vec3i((each_ - 1) * Vec3i::Unit(axis));
        for (int i = 0; i < each_ * each_; ++i) {
            Vec3i at = start + i % each_ * u + i / each_ * v;
            for (int step = 0; step < each_; ++step, at -= side * Vec3i::Unit(axis))
                if (const MaterialId held = heldAt(at); held != MaterialId{0}) {
                    tally.add(held);
                    break;
                }
        }
    }
    void lookAtAll(Tally& tally) const {
        for (int z = 0; z < each_; ++z)
            for (int y = 0; y < each_; ++y)
                for (int x = 0; x < each_; ++x)
                    if (const MaterialId held = heldAt({x, y, z}); held != MaterialId{0})
                        tally.add(held);
    }

    const VoxelGrid& grid_;
    const SampleMaterials& materials_;
    const LabelColumns& columns_;
    int each_;
    const VoxelGrid& coarse_;
    const std::vector<Vec3d>& colors_;
    Vec3i low_ = Vec3i::Zero();  // first sample of the voxel
    Label label_ = Label{0};
    std::vector<bool> inside_;
};

}  // namespace

std::vector<MaterialId> firstMaterials(const VoxelGrid& grid) {
    std::vector<MaterialId> first(grid.labels.size(), MaterialId{0});
    for (std::size_t m = grid.materials.size(); m-- > 1;)
        first[index(grid.materials.raw()[m].label)] = static_cast<MaterialId>(m);
    first[0] = MaterialId{0};
    return first;
}

BrickGrid colorVoxels(const VoxelGrid& grid, const SampleMaterials& materials,
                      const LabelColumns& columns, int each, const VoxelGrid& coarse,
                      const RunContext& run) {
    std::vector<Vec3d> colors;
    for (const Material& material : grid.materials) colors.push_back(oklabOf(material.color));
    BrickGrid painted = coarse.voxels;
    const Vec3i& bricks = painted.bricks();
    const auto count = static_cast<std::size_t>(bricks.x()) * bricks.y() * bricks.z();
    (void)parallelFor(
        count, run,
        [&](std::size_t i) {
            const Vec3i at(static_cast<int>(i % bricks.x()),
                           static_cast<int>(i / bricks.x() % bricks.y()),
                           static_cast<int>(i / bricks.x() / bricks.y()));
            BrickGrid::Brick* brick = painted.brick(at);
            if (!brick) return;
            constexpr std::size_t kSide = BrickGrid::kSide;
            Colorist colorist(grid, materials, columns, each, coarse, colors);
            for (std::size_t v = 0; v < brick->size() && !run.stopped(); ++v) {
                MaterialId& material = (*brick)[v];
                if (material == MaterialId{0}) continue;
                const Vec3i inBrick(static_cast<int>(v % kSide),
                                    static_cast<int>(v / kSide % kSide),
                                    static_cast<int>(v / kSide / kSide));
                material = colorist.materialOf(at * BrickGrid::kSide + inBrick,
                                               grid.materials[material].label);
            }
        },
        1);
    return painted;
}

}  // namespace rivage::core
