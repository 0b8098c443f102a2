#include "core/voxelize/topology.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "core/base/parallel.h"
#include "core/base/union_find.h"

namespace rivage::core {
namespace {

using Topologies = std::vector<VoxelReport::Topology>;

/// Neighbouring voxels of one label along x.
struct Run {
    int begin;
    int end;
    Label label;
};

/// The runs of all rows: those of row (y, z) are runs[start[y + ny z]] up to the next start.
struct Runs {
    int ny;
    std::vector<std::size_t> start{0};
    std::vector<Run> runs;

    [[nodiscard]] std::size_t row(int y, int z) const {
        return y + static_cast<std::size_t>(ny) * z;
    }
};

void addRow(const std::vector<MaterialId>& row, const VoxelGrid& grid, std::vector<Run>& runs) {
    for (int x = 0; x < static_cast<int>(row.size());) {
        const Label label = grid.materials[row[x]].label;
        const int begin = x;
        while (x < static_cast<int>(row.size()) && grid.materials[row[x]].label == label) ++x;
        if (label != Label{0}) runs.push_back({begin, x, label});
    }
}

Runs runsOf(const VoxelGrid& grid, const RunContext& run) {
    const Vec3i& size = grid.voxels.size();
    Runs all{size.y()};
    std::vector<MaterialId> row(static_cast<std::size_t>(size.x()));
    serialFor(
        static_cast<std::size_t>(size.y()) * size.z(), run,
        [&](std::size_t i) {
            const auto y = static_cast<int>(i % size.y());
            const auto z = static_cast<int>(i / size.y());
            if (grid.voxels.copyRow(0, y, z, row)) addRow(row, grid, all.runs);
            all.start.push_back(all.runs.size());
        },
        64);
    return all;
}

/// Calls `join(i, j)` for runs of two rows, each sorted, that lie at most `reach` apart along x.
template <typename Join>
void forEachTouching(const std::vector<Run>& runs, std::size_t begin, std::size_t end,
                     std::size_t otherBegin, std::size_t otherEnd, int reach, Join&& join) {
    std::size_t j = otherBegin;
    for (std::size_t i = begin; i < end; ++i) {
        while (j < otherEnd && runs[j].end + reach <= runs[i].begin) ++j;
        for (std::size_t k = j; k < otherEnd && runs[k].begin < runs[i].end + reach; ++k)
            join(i, k);
    }
}

/// Counts the sets of voxels that hang together by faces, edges or corners.
void countComponents(const Runs& all, int nz, const RunContext& run, Topologies& topologies) {
    constexpr std::array<std::array<int, 2>, 4> kBefore = {{{-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
    UnionFind sets(all.runs.size());
    serialFor(
        all.start.size() - 1, run,
        [&](std::size_t row) {
            const auto y = static_cast<int>(row % all.ny);
            const auto z = static_cast<int>(row / all.ny);
            for (const auto& [dy, dz] : kBefore) {
                if (y + dy < 0 || y + dy >= all.ny || z + dz < 0 || z + dz >= nz) continue;
                const std::size_t other = all.row(y + dy, z + dz);
                forEachTouching(all.runs, all.start[row], all.start[row + 1], all.start[other],
                                all.start[other + 1], 1, [&](std::size_t i, std::size_t j) {
                                    if (all.runs[i].label == all.runs[j].label)
                                        sets.join(static_cast<std::uint32_t>(i),
                                                  static_cast<std::uint32_t>(j));
                                });
            }
        },
        64);
    serialFor(all.runs.size(), run, [&](std::size_t i) {
        if (sets.find(static_cast<std::uint32_t>(i)) == i)
            ++topologies[index(all.runs[i].label) - 1U].components;
    });
}

/// For the 8 voxels around a lattice point, as bits x + 2 y + 4 z: the point, the edges, faces and
/// the voxel that begin there, counted with their signs if one of the voxels has them.
int eulerPart(unsigned voxels) {
    constexpr std::array<unsigned, 3> kHigh = {0xaa, 0xcc, 0xf0};  // voxels on the upper side
    int sum = voxels != 0;
    for (int axis = 0; axis < 3; ++axis) {
        sum -= (voxels & kHigh[axis]) != 0;
        sum += (voxels & kHigh[axis] & kHigh[(axis + 1) % 3]) != 0;
    }
    return sum - (voxels >> 7 & 1);
}

/// Euler numbers by label.
std::vector<std::int64_t> eulerNumbers(const VoxelGrid& grid, const RunContext& run) {
    const Vec3i& size = grid.voxels.size();
    std::vector<std::int64_t> numbers(grid.labels.size(), 0);
    std::array<std::vector<MaterialId>, 4> rows;
    for (auto& row : rows) row.resize(size.x() + 2U);
    serialFor((size.y() + std::size_t{1}) * (size.z() + std::size_t{1}), run,
              [&](std::size_t i) {
                  const auto y = static_cast<int>(i % (size.y() + 1));
                  const auto z = static_cast<int>(i / (size.y() + 1));
                  bool any = false;
                  for (int r = 0; r < 4; ++r)
                      any |= grid.voxels.copyRow(-1, y - 1 + (r & 1), z - 1 + (r >> 1), rows[r]);
                  for (int x = 0; any && x <= size.x(); ++x) {
                      std::array<Label, 8> around;
                      for (int v = 0; v < 8; ++v)
                          around[v] = grid.materials[rows[v >> 1][x + (v & 1)]].label;
                      if (std::all_of(around.begin(), around.end(),
                                      [&](Label l) { return l == around[0]; }))
                          continue;
                      unsigned done = 0;
                      for (int v = 0; v < 8; ++v) {
                          if (done >> v & 1 || around[v] == Label{0}) continue;
                          unsigned same = 0;
                          for (int w = v; w < 8; ++w)
                              same |= (around[w] == around[v] ? 1U : 0U) << w;
                          done |= same;
                          numbers[index(around[v])] += eulerPart(same);
                      }
                  }
              },
              16);
    return numbers;
}

/// The runs of one label with the rows they lie in.
struct LabelRuns {
    struct Placed {
        int y, z, begin, end;
    };
    std::vector<Placed> runs;  // by (z, y, x)
    Vec3i low;
    Vec3i high;  // beyond the last
};

/// Cavities of one label: sets of other voxels, joined by faces, that nothing joins to the outside.
std::uint64_t countCavities(const LabelRuns& label, const RunContext& run) {
    // One more row all around, so that the outside is one set.
    const Vec3i low = label.low - Vec3i::Ones();
    const Vec3i high = label.high + Vec3i::Ones();
    std::vector<Run> gaps;
    std::vector<std::size_t> start{0};
    std::size_t next = 0;
    const int ny = high.y() - low.y();
    const auto rows = static_cast<std::size_t>(ny) * (high.z() - low.z());
    serialFor(
        rows, run,
        [&](std::size_t i) {
            const int y = low.y() + static_cast<int>(i % ny);
            const int z = low.z() + static_cast<int>(i / ny);
            int x = low.x();
            for (; next < label.runs.size() && label.runs[next].y == y && label.runs[next].z == z;
                 ++next) {
                if (label.runs[next].begin > x)
                    gaps.push_back({x, label.runs[next].begin, Label{0}});
                x = label.runs[next].end;
            }
            gaps.push_back({x, high.x(), Label{0}});
            start.push_back(gaps.size());
        },
        256);
    UnionFind sets(gaps.size());
    std::uint64_t joined = 0;
    serialFor(
        start.size() - 1, run,
        [&](std::size_t row) {
            const auto join = [&](std::size_t other) {
                forEachTouching(gaps, start[row], start[row + 1], start[other], start[other + 1], 0,
                                [&](std::size_t i, std::size_t j) {
                                    const auto a = sets.find(static_cast<std::uint32_t>(i));
                                    const auto b = sets.find(static_cast<std::uint32_t>(j));
                                    if (a == b) return;
                                    sets.join(a, b);
                                    ++joined;
                                });
            };
            if (row % ny != 0) join(row - 1);
            if (row >= static_cast<std::size_t>(ny)) join(row - ny);
        },
        256);
    return gaps.size() - joined - 1;
}

std::vector<LabelRuns> byLabel(const Runs& all, std::size_t labels) {
    std::vector<LabelRuns> result(labels);
    for (std::size_t row = 0; row + 1 < all.start.size(); ++row) {
        const auto y = static_cast<int>(row % all.ny);
        const auto z = static_cast<int>(row / all.ny);
        for (std::size_t i = all.start[row]; i < all.start[row + 1]; ++i) {
            const Run& run = all.runs[i];
            LabelRuns& label = result[index(run.label) - 1U];
            const Vec3i low(run.begin, y, z);
            const Vec3i high(run.end, y + 1, z + 1);
            label.low = label.runs.empty() ? low : Vec3i(label.low.cwiseMin(low));
            label.high = label.runs.empty() ? high : Vec3i(label.high.cwiseMax(high));
            label.runs.push_back({y, z, run.begin, run.end});
        }
    }
    return result;
}

}  // namespace

Result<Topologies> labelTopology(const VoxelGrid& grid, const RunContext& run) {
    Topologies topologies(grid.labels.size() - 1);
    const Runs all = runsOf(grid, run);
    if (run.stopped()) return fail(run.stopError());
    countComponents(all, grid.voxels.size().z(), run, topologies);
    const std::vector<std::int64_t> euler = eulerNumbers(grid, run);
    const std::vector<LabelRuns> labels = byLabel(all, topologies.size());
    for (std::size_t i = 0; i < labels.size(); ++i) {
        if (run.stopped()) return fail(run.stopError());
        if (labels[i].runs.empty()) continue;
        VoxelReport::Topology& topology = topologies[i];
        topology.cavities = countCavities(labels[i], run);
        topology.tunnels =
            topology.components + topology.cavities - static_cast<std::uint64_t>(euler[i + 1]);
    }
    if (run.stopped()) return fail(run.stopError());
    return topologies;
}

}  // namespace rivage::core
