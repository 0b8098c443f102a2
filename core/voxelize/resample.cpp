#include "core/voxelize/resample.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

constexpr int kSide = BrickGrid::kSide;
static_assert(kSide == ColumnBlock::kSide);

/// Calls `visit(begin, end, label)` for the runs of a column that are not background.
template <typename Visit>
void forEachRun(std::span<const LabelRun> column, int columnEnd, Visit&& visit) {
    for (std::size_t i = 0; i < column.size(); ++i) {
        const int end = i + 1 < column.size() ? column[i + 1].begin : columnEnd;
        if (column[i].label != Label{0}) visit(column[i].begin, end, column[i].label);
    }
}

std::span<const LabelRun> columnOf(const LabelColumns::Block& block, int column) {
    return {block.runs.data() + block.starts[column], block.runs.data() + block.starts[column + 1]};
}

/// The bricks that hold something, and how many voxels.
struct Reach {
    std::vector<bool> bricks;
    std::uint64_t brickCount = 0;
    std::uint64_t voxels = 0;
};

/// Means nothing once `run` asked to stop.
Reach reachOf(const LabelColumns& columns, const RunContext& run) {
    const Vec3i& size = columns.lattice().size;
    const std::size_t blocks = columns.blocks().size();
    const int layers = (size.z() + kSide - 1) / kSide;
    Reach reach;
    reach.bricks.assign(blocks * layers, false);
    serialFor(
        blocks, run,
        [&](std::size_t i) {
            const LabelColumns::Block& block = columns.blocks()[i];
            if (block.starts.empty()) return;
            for (int c = 0; c < ColumnBlock::kColumns; ++c)
                forEachRun(columnOf(block, c), size.z(), [&](int begin, int end, Label) {
                    reach.voxels += static_cast<std::uint64_t>(end - begin);
                    for (int z = begin / kSide; z <= (end - 1) / kSide; ++z)
                        reach.bricks[i + blocks * z] = true;
                });
        },
        16);
    reach.brickCount =
        static_cast<std::uint64_t>(std::count(reach.bricks.begin(), reach.bricks.end(), true));
    return reach;
}

Result<void> checkReach(const Reach& reach, const Limits& limits) {
    if (reach.voxels > limits.maxVoxels)
        return fail(Error{ErrorCode::tooLarge,
                          "at this scale the model has " + std::to_string(reach.voxels) +
                              " voxels, at most " + std::to_string(limits.maxVoxels) +
                              " are allowed",
                          "/options/scale", limits.maxVoxels, reach.voxels, "--max-voxels"});
    const std::uint64_t memory = reach.brickCount * sizeof(BrickGrid::Brick);
    if (memory > limits.maxMemory)
        return fail(Error{ErrorCode::memoryBudget,
                          "the voxels at this scale take more memory (bytes) than the budget of "
                          "one conversion",
                          "/options/scale", limits.maxMemory, memory, "--memory-budget"});
    return {};
}

/// The voxels of the input around one brick of samples.
class Held {
public:
    Held(const VoxelGrid& grid, const SampleLattice& lattice, const Vec3i& base) {
        const Vec3i last =
            (base + Vec3i::Constant(kSide - 1)).cwiseMin(lattice.size - Vec3i::Ones());
        low_ = lattice.voxelOf(base);
        size_ = lattice.voxelOf(last) - low_ + Vec3i::Ones();
        cells_.resize(static_cast<std::size_t>(size_.prod()));
        for (int z = 0; z < size_.z(); ++z)
            for (int y = 0; y < size_.y(); ++y)
                grid.voxels.copyRow(low_.x(), low_.y() + y, low_.z() + z,
                                    {cells_.data() + row(y, z), std::size_t(size_.x())});
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < kSide; ++i)
                place_[axis][i] =
                    std::min(lattice.voxelOf(base[axis] + i) - low_[axis], size_[axis] - 1);
    }
    /// The material of the voxel that holds a sample of the brick.
    [[nodiscard]] MaterialId at(int x, int y, int z) const {
        return cells_[row(place_[1][y], place_[2][z]) + place_[0][x]];
    }

private:
    [[nodiscard]] std::size_t row(int y, int z) const {
        return static_cast<std::size_t>(size_.x()) * (y + static_cast<std::size_t>(size_.y()) * z);
    }
    Vec3i low_;
    Vec3i size_;
    std::vector<MaterialId> cells_;
    std::array<std::array<int, kSide>, 3> place_{};
};

/// Labels of the samples of a brick, x fastest.
using BrickLabels = std::array<Label, BrickGrid::kBrickVoxels>;

/// The labels of one brick after another, upwards.
class BlockLabels {
public:
    BlockLabels(const LabelColumns::Block& block, int columnEnd)
        : block_(block), columnEnd_(columnEnd) {
        std::copy(block.starts.begin(), block.starts.end() - 1, next_.begin());
    }
    void fill(int layer, BrickLabels& labels) {
        labels.fill(Label{0});
        const int low = layer * kSide;
        const int high = std::min(low + kSide, columnEnd_);
        for (int c = 0; c < ColumnBlock::kColumns; ++c) {
            const std::uint32_t end = block_.starts[c + 1];
            // The last run that begins at or below `low`, or the first of the column.
            while (next_[c] + 1 < end && block_.runs[next_[c] + 1].begin <= low) ++next_[c];
            for (std::uint32_t i = next_[c]; i < end && block_.runs[i].begin < high; ++i) {
                const int from = std::max(block_.runs[i].begin, low);
                const int to = i + 1 < end ? std::min(block_.runs[i + 1].begin, high) : high;
                for (int z = from; z < to; ++z)
                    labels[c + ColumnBlock::kColumns * (z - low)] = block_.runs[i].label;
            }
        }
    }

private:
    const LabelColumns::Block& block_;
    int columnEnd_;
    std::array<std::uint32_t, ColumnBlock::kColumns> next_{};
};

void fillBrick(const BrickLabels& labels, const Held& held, const SampleLattice& lattice,
               const Vec3i& base, const SampleMaterials& materials, BrickGrid::Brick& brick) {
    std::size_t i = 0;
    for (int z = 0; z < kSide; ++z)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x, ++i)
                if (labels[i] != Label{0})
                    brick[i] = materials.of(held.at(x, y, z), labels[i],
                                            lattice.position(base + Vec3i(x, y, z)));
}

}  // namespace

SampleMaterials::SampleMaterials(const VoxelGrid& grid, const NearestSurfel& nearest)
    : grid_(grid), nearest_(nearest) {}

MaterialId SampleMaterials::nearestOf(Label label, const Vec3d& at) const {
    const SurfelId s = nearest_.find(at, label).surfel;
    if (s != kNone<SurfelId>) return nearest_.materialOf(s, label);
    for (std::size_t m = 1; m < grid_.materials.size(); ++m)
        if (grid_.materials.raw()[m].label == label) return static_cast<MaterialId>(m);
    return MaterialId{0};
}

Result<VoxelGrid> resample(const VoxelGrid& grid, const NearestSurfel& nearest,
                           const LabelColumns& columns, const RunContext& run) {
    const SampleLattice& lattice = columns.lattice();
    const Reach reach = reachOf(columns, run);
    if (run.stopped()) return fail(run.stopError());
    if (const auto fits = checkReach(reach, run.limits); !fits) return fail(fits.error());

    VoxelGrid fine;
    fine.voxels = BrickGrid(lattice.size, reach.bricks);
    fine.materials = grid.materials;
    fine.labels = grid.labels;
    fine.openBorder = grid.openBorder;
    fine.spacing = grid.spacing;
    const SampleMaterials materials(grid, nearest);
    const std::size_t blocks = columns.blocks().size();
    const bool done = parallelBlocks(blocks, 1, run, [&](std::size_t begin, std::size_t end) {
        BrickLabels labels;
        for (std::size_t i = begin; i < end; ++i) {
            const LabelColumns::Block& block = columns.blocks()[i];
            if (block.starts.empty()) continue;
            BlockLabels upwards(block, lattice.size.z());
            const ColumnBlock place = columns.place(i);
            for (int layer = 0; layer < fine.voxels.bricks().z() && !run.stopped(); ++layer) {
                if (!reach.bricks[i + blocks * layer]) continue;
                upwards.fill(layer, labels);
                const Vec3i base(place.x, place.y, layer * kSide);
                fillBrick(labels, Held(grid, lattice, base), lattice, base, materials,
                          *fine.voxels.brick(base / kSide));
            }
        }
    });
    if (!done || run.stopped()) return fail(run.stopError());
    return fine;
}

}  // namespace rivage::core
