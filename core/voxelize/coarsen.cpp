#include "core/voxelize/coarsen.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/voxelize/coarse_colors.h"
#include "core/voxelize/thin_parts.h"

namespace rivage::core {
namespace {

constexpr int kLeastSamples = 4;   // along each axis: a label's share to within 1/64
constexpr int kLeastPerVoxel = 2;  // of the input, so that none is missed

/// Samples of each label in one voxel of the result; a handful of labels.
using Shares = std::vector<std::pair<Label, int>>;

void addShare(Shares& shares, Label label, int samples) {
    for (auto& [other, count] : shares)
        if (other == label) {
            count += samples;
            return;
        }
    shares.emplace_back(label, samples);
}

/// The shares of the voxels of the result over one another at (x, y).
void collectShares(const LabelColumns& columns, int x, int y, int each,
                   std::vector<Shares>& shares) {
    for (Shares& voxel : shares) voxel.clear();
    for (int v = y * each; v < (y + 1) * each; ++v)
        for (int u = x * each; u < (x + 1) * each; ++u) {
            const auto column = columns.column(u, v);
            for (std::size_t i = 0; i < column.size(); ++i) {
                if (column[i].label == Label{0}) continue;
                int z = column[i].begin;
                const int end =
                    i + 1 < column.size() ? column[i + 1].begin : columns.lattice().size.z();
                while (z < end) {
                    const int to = std::min((z / each + 1) * each, end);
                    addShare(shares[z / each], column[i].label, to - z);
                    z = to;
                }
            }
        }
}

/// What the samples say about some voxels of the result.
struct Votes {
    std::vector<VotedVoxel> majority;    // solid ones
    std::vector<VotedVoxel> candidates;  // labels with a third and more that lost
};

void vote(Shares& shares, const Vec3i& voxel, int samples, Votes& votes) {
    if (shares.empty()) return;
    std::sort(shares.begin(), shares.end());
    int solid = 0;
    std::pair<Label, int> most{Label{0}, 0};
    for (const auto& share : shares) {
        solid += share.second;
        if (share.second > most.second) most = share;
    }
    const Label winner = most.second >= samples - solid ? most.first : Label{0};
    if (winner != Label{0}) votes.majority.push_back({voxel, winner});
    for (const auto& [label, count] : shares)
        if (label != winner && 3 * std::int64_t{count} >= samples)
            votes.candidates.push_back({voxel, label});
}

/// @return  by row of voxels along x; incomplete once `run` asked to stop
std::vector<Votes> voteAll(const LabelColumns& columns, const Vec3i& size, int each,
                           const RunContext& run) {
    std::vector<Votes> rows(static_cast<std::size_t>(size.y()));
    (void)parallelFor(
        rows.size(), run,
        [&](std::size_t row) {
            const auto y = static_cast<int>(row);
            std::vector<Shares> shares(static_cast<std::size_t>(size.z()));
            for (int x = 0; x < size.x() && !run.stopped(); ++x) {
                collectShares(columns, x, y, each, shares);
                for (int z = 0; z < size.z(); ++z)
                    vote(shares[z], {x, y, z}, each * each * each, rows[row]);
            }
        },
        1);
    return rows;
}

}  // namespace

SampleLattice samplesFor(const Vec3i& size, const Scale& scale) {
    const int each =
        std::max(kLeastSamples, (kLeastPerVoxel * scale.down + scale.up - 1) / scale.up);
    const int common = std::gcd(scale.up * each, scale.down);
    return {scale.up * each / common, scale.down / common, size * each};
}

Result<VoxelGrid> coarsen(const VoxelGrid& grid, const NearestSurfel& nearest,
                          const LabelColumns& columns, const Vec3i& size, const RunContext& run,
                          VoxelReport& report) {
    const int each = columns.lattice().size.x() / size.x();
    const std::vector<Votes> rows = voteAll(columns, size, each, run);
    if (run.stopped()) return fail(run.stopError());

    VoxelGrid coarse;
    coarse.voxels = BrickGrid(size);
    coarse.materials = grid.materials;
    coarse.labels = grid.labels;
    coarse.openBorder = grid.openBorder;
    coarse.spacing = grid.spacing;
    const std::vector<MaterialId> stand = firstMaterials(grid);
    std::vector<VotedVoxel> candidates;
    for (const Votes& votes : rows) {
        if (run.stopped()) return fail(run.stopError());
        for (const VotedVoxel& voxel : votes.majority)
            coarse.voxels.set(voxel.at, stand[index(voxel.label)]);
        candidates.insert(candidates.end(), votes.candidates.begin(), votes.candidates.end());
    }
    report.samplesEach = static_cast<std::uint64_t>(each) * each * each;
    report.rescued = keepThinParts(coarse, std::move(candidates), stand, run);
    if (run.stopped()) return fail(run.stopError());
    const SampleMaterials materials(grid, nearest);
    coarse.voxels = colorVoxels(grid, materials, columns, each, coarse, run);
    if (run.stopped()) return fail(run.stopError());
    return coarse;
}

}  // namespace rivage::core
