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
    void clear() { counts_.clear(); }
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

bool showsFace(const VoxelGrid& grid, const Vec3i& voxel, Label label) {
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1})
            if (grid.labelAt(voxel + side * Vec3i::Unit(axis)) != label) return true;
    return false;
}

/// Tells the material of one voxel after another.
class Colorist {
public:
    Colorist(const VoxelGrid& grid, const SampleMaterials& materials, const LabelColumns& columns,
             int each, const std::vector<Vec3d>& colors)
        : grid_(grid), materials_(materials), columns_(columns), each_(each), colors_(colors) {}

    MaterialId materialOf(const Vec3i& voxel, Label label) {
        visible_.clear();
        hidden_.clear();
        const Vec3i low = voxel * each_;
        for (int y = low.y(); y < low.y() + each_; ++y)
            for (int x = low.x(); x < low.x() + each_; ++x) addColumn(x, y, low.z(), label);
        if (!visible_.empty()) return visible_.mode(colors_);
        if (!hidden_.empty()) return hidden_.mode(colors_);
        const Vec3i middle = low + Vec3i::Constant(each_ / 2);
        return materials_.nearestOf(label, columns_.lattice().position(middle));
    }

private:
    void addColumn(int x, int y, int zBegin, Label label) {
        const auto column = columns_.column(x, y);
        const SampleLattice& lattice = columns_.lattice();
        for (std::size_t i = 0; i < column.size(); ++i) {
            const int end = i + 1 < column.size() ? column[i + 1].begin : lattice.size.z();
            if (end <= zBegin || column[i].label != label) continue;
            if (column[i].begin >= zBegin + each_) break;
            for (int z = std::max(column[i].begin, zBegin); z < std::min(end, zBegin + each_); ++z)
                addSample(lattice.voxelOf(Vec3i(x, y, z)), label);
        }
    }
    void addSample(const Vec3i& voxel, Label label) {
        const MaterialId held = grid_.voxels.at(voxel);
        if (grid_.materials[held].label != label) return;
        if (voxel != last_) shows_ = showsFace(grid_, voxel, label);
        last_ = voxel;
        (shows_ ? visible_ : hidden_).add(held);
    }

    const VoxelGrid& grid_;
    const SampleMaterials& materials_;
    const LabelColumns& columns_;
    int each_;
    const std::vector<Vec3d>& colors_;
    Tally visible_;
    Tally hidden_;
    Vec3i last_ = Vec3i::Constant(-1);
    bool shows_ = false;
};

}  // namespace

std::vector<MaterialId> firstMaterials(const VoxelGrid& grid) {
    std::vector<MaterialId> first(grid.labels.size(), MaterialId{0});
    for (std::size_t m = grid.materials.size(); m-- > 1;)
        first[index(grid.materials.raw()[m].label)] = static_cast<MaterialId>(m);
    first[0] = MaterialId{0};
    return first;
}

bool colorVoxels(const VoxelGrid& grid, const SampleMaterials& materials,
                 const LabelColumns& columns, int each, VoxelGrid& coarse, const RunContext& run) {
    std::vector<Vec3d> colors;
    for (const Material& material : grid.materials) colors.push_back(oklabOf(material.color));
    const Vec3i& bricks = coarse.voxels.bricks();
    const auto count = static_cast<std::size_t>(bricks.x()) * bricks.y() * bricks.z();
    return parallelFor(
        count, run,
        [&](std::size_t i) {
            const Vec3i at(static_cast<int>(i % bricks.x()),
                           static_cast<int>(i / bricks.x() % bricks.y()),
                           static_cast<int>(i / bricks.x() / bricks.y()));
            BrickGrid::Brick* brick = coarse.voxels.brick(at);
            if (!brick) return;
            Colorist colorist(grid, materials, columns, each, colors);
            for (std::size_t v = 0; v < brick->size() && !run.stopped(); ++v) {
                MaterialId& material = (*brick)[v];
                if (material == MaterialId{0}) continue;
                const Vec3i voxel =
                    at * BrickGrid::kSide +
                    Vec3i(static_cast<int>(v % BrickGrid::kSide),
                          static_cast<int>(v / BrickGrid::kSide % BrickGrid::kSide),
                          static_cast<int>(v / BrickGrid::kSide / BrickGrid::kSide));
                material = colorist.materialOf(voxel, grid.materials[material].label);
            }
        },
        1);
}

}  // namespace rivage::core
