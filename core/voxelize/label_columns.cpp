#include "core/voxelize/label_columns.h"

#include <algorithm>
#include <tuple>

#include "core/base/parallel.h"
#include "core/voxelize/open_border.h"
#include "core/voxelize/windings.h"

namespace rivage::core {
namespace {

constexpr int kSide = ColumnBlock::kSide;

/// The surfels that the columns of each block may pass: those of block i are
/// items[start[i]] to items[start[i + 1]].
struct Buckets {
    std::vector<std::size_t> start;
    std::vector<SurfelId> items;
};

/// Means nothing once `run` asked to stop.
Buckets sortIntoBlocks(const MovedSurface& moved, const LabelColumns& columns,
                       const RunContext& run) {
    Buckets buckets;
    buckets.start.assign(columns.blocks().size() + 1, 0);
    const auto forEachBlock = [&](auto&& visit) {
        serialFor(moved.surface.surfelCount(), run, [&](std::size_t i) {
            const SurfelId s{static_cast<std::uint32_t>(i)};
            const SampleRange under = samplesUnder(moved, s, columns.lattice());
            if (under.xBegin > under.xLast || under.yBegin > under.yLast) return;
            for (int y = under.yBegin / kSide; y <= under.yLast / kSide; ++y)
                for (int x = under.xBegin / kSide; x <= under.xLast / kSide; ++x)
                    visit(s, x + static_cast<std::size_t>(columns.blocksX()) * y);
        });
    };
    forEachBlock([&](SurfelId, std::size_t block) { ++buckets.start[block + 1]; });
    for (std::size_t i = 1; i < buckets.start.size(); ++i) buckets.start[i] += buckets.start[i - 1];
    buckets.items.resize(buckets.start.back());
    std::vector<std::size_t> next(buckets.start.begin(), buckets.start.end() - 1);
    forEachBlock([&](SurfelId s, std::size_t block) { buckets.items[next[block]++] = s; });
    return buckets;
}

/// Turns the faces that columns pass into runs of labels.
class BlockScanner {
public:
    BlockScanner(const SampleLattice& lattice, const NearestSurfel& nearest,
                 const ColumnBlock& place, LabelColumns::Block& block)
        : lattice_(lattice), nearest_(nearest), place_(place), block_(block) {}

    /// @param crossings  of this column, by sample
    void addColumn(int x, int y, Windings windings, std::span<const Crossing> crossings) {
        last_ = Label{0};
        std::size_t next = 0;
        for (int sample = 0; sample < lattice_.size.z();) {
            while (next < crossings.size() && crossings[next].sample <= sample) {
                windings.pass(crossings[next].from, crossings[next].to);
                ++next;
            }
            const int end = next < crossings.size() ? crossings[next].sample : lattice_.size.z();
            addSamples(windings, {place_.x + x, place_.y + y, sample}, end);
            sample = end;
        }
    }

private:
    void addSamples(const Windings& windings, const Vec3i& first, int end) {
        if (const auto only = windings.only()) return addRun(first.z(), *only);
        block_.folded += static_cast<std::uint64_t>(end - first.z());
        const std::vector<Label> most = windings.most();
        if (most.size() == 1) return addRun(first.z(), most.front());
        for (int z = first.z(); z < end; ++z)
            addRun(z, nearestOf(most, lattice_.position({first.x(), first.y(), z})));
    }

    /// On a tie the smaller label, and the background last of all.
    [[nodiscard]] Label nearestOf(std::vector<Label> labels, const Vec3d& at) const {
        if (labels.front() == Label{0})
            std::rotate(labels.begin(), labels.begin() + 1, labels.end());
        Label best = labels.front();
        NearestSurfel::Hit nearest;
        for (const Label label : labels) {
            const NearestSurfel::Hit hit = nearest_.find(at, label);
            if (hit.surfel == kNone<SurfelId>) continue;
            if (nearest.surfel != kNone<SurfelId> && hit.squaredDistance >= nearest.squaredDistance)
                continue;
            best = label;
            nearest = hit;
        }
        return best;
    }

    void addRun(int begin, Label label) {
        if (label == last_) return;
        last_ = label;
        block_.runs.push_back({begin, label});
    }

    const SampleLattice& lattice_;
    const NearestSurfel& nearest_;
    ColumnBlock place_;
    LabelColumns::Block& block_;
    Label last_ = Label{0};
};

/// The crossings of one block, by column and sample.
void collectCrossings(const MovedSurface& moved, std::span<const SurfelId> surfels,
                      const SampleLattice& lattice, const ColumnBlock& place,
                      std::vector<Crossing>& crossings) {
    crossings.clear();
    for (const SurfelId s : surfels) appendCrossings(moved, s, lattice, place, crossings);
    // Which of two crossings at one sample comes first makes no difference to the sums.
    std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
        return std::tie(a.column, a.sample) < std::tie(b.column, b.sample);
    });
}

void scanBlock(const OpenBorder& border, std::span<const Crossing> crossings,
               const SampleLattice& lattice, const NearestSurfel& nearest, const ColumnBlock& place,
               LabelColumns::Block& block) {
    if (border.isClosed() && crossings.empty()) return;
    BlockScanner scanner(lattice, nearest, place, block);
    auto next = crossings.begin();
    block.starts.push_back(0);
    for (int y = 0; y < kSide; ++y) {
        const bool inside = place.y + y < lattice.size.y();
        const std::vector<Windings> below = inside && !border.isClosed()
                                                ? border.below(place.x, kSide, place.y + y)
                                                : std::vector<Windings>(kSide, Windings(Label{0}));
        for (int x = 0; x < kSide; ++x) {
            const int column = x + kSide * y;
            const auto end = std::find_if(next, crossings.end(),
                                          [&](const Crossing& c) { return c.column != column; });
            if (inside && place.x + x < lattice.size.x())
                scanner.addColumn(x, y, below[x], {next, end});
            next = end;
            block.starts.push_back(static_cast<std::uint32_t>(block.runs.size()));
        }
    }
    block.runs.shrink_to_fit();
}

}  // namespace

LabelColumns::LabelColumns(const SampleLattice& lattice) : lattice_(lattice) {
    blocksX_ = (lattice.size.x() + kSide - 1) / kSide;
    const int blocksY = (lattice.size.y() + kSide - 1) / kSide;
    blocks_.resize(static_cast<std::size_t>(blocksX_) * blocksY);
}

std::span<const LabelRun> LabelColumns::column(int x, int y) const {
    const Block& block = blocks_[x / kSide + static_cast<std::size_t>(blocksX_) * (y / kSide)];
    if (block.starts.empty()) return {};
    const int column = x % kSide + kSide * (y % kSide);
    return {block.runs.data() + block.starts[column], block.runs.data() + block.starts[column + 1]};
}

std::uint64_t LabelColumns::folded() const {
    std::uint64_t count = 0;
    for (const Block& block : blocks_) count += block.folded;
    return count;
}

Result<LabelColumns> scanLabels(const VoxelGrid& grid, const MovedSurface& moved,
                                const NearestSurfel& nearest, const SampleLattice& lattice,
                                const RunContext& run) {
    LabelColumns columns(lattice);
    const Buckets buckets = sortIntoBlocks(moved, columns, run);
    const OpenBorder border(grid, moved, lattice, run);
    if (run.stopped()) return fail(run.stopError());
    const bool done =
        parallelBlocks(columns.blocks().size(), 1, run, [&](std::size_t begin, std::size_t end) {
            std::vector<Crossing> crossings;
            for (std::size_t i = begin; i < end; ++i) {
                const ColumnBlock place = columns.place(i);
                const std::span<const SurfelId> surfels(
                    buckets.items.data() + buckets.start[i],
                    buckets.items.data() + buckets.start[i + 1]);
                collectCrossings(moved, surfels, lattice, place, crossings);
                scanBlock(border, crossings, lattice, nearest, place, columns.blocks()[i]);
            }
        });
    if (!done) return fail(run.stopError());
    return columns;
}

}  // namespace rivage::core
