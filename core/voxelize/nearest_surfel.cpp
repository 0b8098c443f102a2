#include "core/voxelize/nearest_surfel.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/base/parallel.h"

namespace rivage::core {

Vec3i NearestSurfel::cellOf(const Vec3d& at) const {
    Vec3i cell;
    for (int axis = 0; axis < 3; ++axis)
        cell[axis] = static_cast<int>(std::clamp(std::floor(at[axis]), 0.0, grid_[axis] - 1.0));
    return cell;
}

Result<NearestSurfel> NearestSurfel::build(const MovedSurface& moved, const Vec3i& grid,
                                           const RunContext& run) {
    NearestSurfel table(moved, grid);
    table.rows_.assign(static_cast<std::size_t>(grid.y()) * grid.z() + 1, 0);
    const auto forEachCell = [&](auto&& visit) {
        return serialFor(moved.surface.surfelCount(), run, [&](std::size_t i) {
            const SurfelId s{static_cast<std::uint32_t>(i)};
            const Vec3i cell = table.cellOf(moved.centre(s));
            visit(s, cell.x(), table.row(cell.y(), cell.z()));
        });
    };
    if (!forEachCell([&](SurfelId, int, std::size_t row) { ++table.rows_[row + 1]; }))
        return fail(run.stopError());
    for (std::size_t i = 1; i < table.rows_.size(); ++i) table.rows_[i] += table.rows_[i - 1];
    table.entries_.resize(moved.surface.surfelCount());
    std::vector<std::size_t> next(table.rows_.begin(), table.rows_.end() - 1);
    if (!forEachCell([&](SurfelId s, int x, std::size_t row) {
            table.entries_[next[row]++] = {x, s};
        }))
        return fail(run.stopError());
    const bool sorted = parallelFor(table.rows_.size() - 1, run, [&](std::size_t row) {
        const auto at = [&](std::size_t i) {
            return table.entries_.begin() + static_cast<std::ptrdiff_t>(table.rows_[i]);
        };
        std::stable_sort(at(row), at(row + 1),
                         [](const Entry& a, const Entry& b) { return a.x < b.x; });
    });
    if (!sorted) return fail(run.stopError());
    return table;
}

void NearestSurfel::visitRow(int y, int z, int xBegin, int xEnd, const Vec3d& at, Label label,
                             Hit& best) const {
    if (y < 0 || z < 0 || y >= grid_.y() || z >= grid_.z()) return;
    const std::size_t r = row(y, z);
    const auto end = entries_.begin() + static_cast<std::ptrdiff_t>(rows_[r + 1]);
    auto entry = std::lower_bound(entries_.begin() + static_cast<std::ptrdiff_t>(rows_[r]), end,
                                  xBegin, [](const Entry& e, int x) { return e.x < x; });
    for (; entry != end && entry->x < xEnd; ++entry) {
        const LabelPair labels = moved_->labels(entry->surfel);
        if (labels.inner != label && labels.outer != label) continue;
        const Vec3d way =
            (moved_->centre(entry->surfel) - at).cwiseProduct(moved_->surface.spacing);
        const double distance = way.squaredNorm();
        const bool nearer =
            best.surfel == kNone<SurfelId> || distance < best.squaredDistance ||
            (distance == best.squaredDistance && index(entry->surfel) < index(best.surfel));
        if (nearer) best = {entry->surfel, distance};
    }
}

/// The cells at `ring` steps from a cell, in the sup norm.
void NearestSurfel::visitRing(const Vec3i& cell, int ring, const Vec3d& at, Label label,
                              Hit& best) const {
    for (int dz = -ring; dz <= ring; ++dz)
        for (int dy = -ring; dy <= ring; ++dy) {
            const int y = cell.y() + dy;
            const int z = cell.z() + dz;
            const int x = cell.x();
            if (std::max(std::abs(dy), std::abs(dz)) == ring) {
                visitRow(y, z, x - ring, x + ring + 1, at, label, best);
                continue;
            }
            visitRow(y, z, x - ring, x - ring + 1, at, label, best);
            visitRow(y, z, x + ring, x + ring + 1, at, label, best);
        }
}

NearestSurfel::Hit NearestSurfel::find(const Vec3d& at, Label label) const {
    const Vec3i cell = cellOf(at);
    Hit best;
    // Faces beyond the ring r are more than r cells away, and a cell is at least 1 long.
    for (int ring = 0; ring <= grid_.maxCoeff(); ++ring) {
        visitRing(cell, ring, at, label, best);
        if (best.surfel != kNone<SurfelId> && best.squaredDistance <= double(ring) * ring) break;
    }
    return best;
}

}  // namespace rivage::core
