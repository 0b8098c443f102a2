#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/voxelize/crossings.h"
#include "core/voxelize/nearest_surfel.h"

namespace rivage::core {

/// From `begin` up to the next run of its column all samples have this label.
struct LabelRun {
    std::int32_t begin = 0;
    Label label = Label{0};
};

/// The labels of all samples of a lattice, as runs along z. Columns without a run, and the samples
/// before the first run of a column, are background.
class LabelColumns {
public:
    /// Those of 16 x 16 columns; empty where all samples are background.
    struct Block {
        std::vector<std::uint32_t> starts;  ///< of the runs of each column, and their end
        std::vector<LabelRun> runs;
        std::uint64_t folded = 0;  ///< samples where the surface is folded over itself
    };

    explicit LabelColumns(const SampleLattice& lattice);

    [[nodiscard]] const SampleLattice& lattice() const { return lattice_; }
    [[nodiscard]] int blocksX() const { return blocksX_; }
    [[nodiscard]] std::vector<Block>& blocks() { return blocks_; }
    [[nodiscard]] const std::vector<Block>& blocks() const { return blocks_; }
    [[nodiscard]] ColumnBlock place(std::size_t block) const {
        return {static_cast<int>(block % blocksX_) * ColumnBlock::kSide,
                static_cast<int>(block / blocksX_) * ColumnBlock::kSide};
    }
    [[nodiscard]] std::span<const LabelRun> column(int x, int y) const;
    /// Samples where the surface is folded over itself, so that a vote decided.
    [[nodiscard]] std::uint64_t folded() const;

private:
    SampleLattice lattice_;
    int blocksX_ = 0;
    std::vector<Block> blocks_;
};

/// Which label each sample of a lattice has in a regularized model: exact scan conversion of all
/// interfaces at once. Each column of samples collects the faces that it passes; every face takes
/// one from the label below and gives one to the label above. Where a single label is left with 1,
/// that is the label of the sample; where the surface is folded over itself, the label with the
/// most, on a tie the one whose nearest face is nearest.
///
/// @param nearest  of the same surface
/// @return  the same for any number of threads. With displacements below half a voxel, samples at
///          voxel centres have the labels of their voxels
/// @errors  cancelled
/// @cost    O(columns that a face covers + columns of bricks); 8 bytes a face passed
/// @source  METHOD.md 5
Result<LabelColumns> scanLabels(const VoxelGrid& grid, const MovedSurface& moved,
                                const NearestSurfel& nearest, const SampleLattice& lattice,
                                const RunContext& run);

}  // namespace rivage::core
