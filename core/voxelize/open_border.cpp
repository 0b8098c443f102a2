#include "core/voxelize/open_border.h"

#include <algorithm>
#include <tuple>

#include "core/base/parallel.h"

namespace rivage::core {

OpenBorder::OpenBorder(const VoxelGrid& grid, const MovedSurface& moved,
                       const SampleLattice& lattice, const RunContext& run)
    : open_(grid.openBorder), corner_(Label{0}) {
    if (!open_) return;
    corner_ = grid.labelAt(Vec3i::Zero());
    const DigitalSurface& surface = moved.surface;
    serialFor(surface.surfelCount(), run, [&](std::size_t i) {
        const SurfelId s{static_cast<std::uint32_t>(i)};
        const auto& corners = surface.corners[s];
        for (std::size_t k = 0; k < 4; ++k) {
            const PointelId a = corners[k];
            const PointelId b = corners[(k + 1) % 4];
            if (surface.pointels[a].z() == 0 && surface.pointels[b].z() == 0)
                addEdge(moved, s, a, b, lattice);
        }
    });
    const auto order = [](const Pass& a, const Pass& b) {
        return std::tie(a.line, a.sample) < std::tie(b.line, b.sample);
    };
    std::sort(alongX_.begin(), alongX_.end(), order);
    std::sort(alongY_.begin(), alongY_.end(), order);
}

// The corners of a face run counter-clockwise seen from its outer side, so with the face above it
// an edge that runs up along y has the outer side at greater x, and one that runs down along x
// has it at greater y.
void OpenBorder::addEdge(const MovedSurface& moved, SurfelId s, PointelId a, PointelId b,
                         const SampleLattice& lattice) {
    const DigitalSurface& surface = moved.surface;
    const LabelPair labels = moved.labels(s);
    const auto at = [&](PointelId p, int axis) {
        return std::int64_t{moved.snapped[p][axis]} * lattice.up;
    };
    if (surface.pointels[b].x() == 0)
        alongY_.push_back({0, lattice.firstFrom(at(b, 1)), labels.inner, labels.outer});
    if (surface.pointels[a].x() == 0)
        alongY_.push_back({0, lattice.firstFrom(at(a, 1)), labels.outer, labels.inner});

    const bool up = at(a, 1) < at(b, 1);
    const PointelId low = up ? a : b;
    const PointelId high = up ? b : a;
    const Int128 dx = at(high, 0) - at(low, 0);
    const Int128 dy = at(high, 1) - at(low, 1);
    const std::int64_t base = lattice.firstFrom(at(low, 0));
    const Int128 offset = dy * (at(low, 0) - (lattice.at(0) + base * lattice.step()));
    const Int128 step = dy * lattice.step();
    const auto end = std::min<std::int64_t>(lattice.firstFrom(at(high, 1)), lattice.size.y());
    // A row on the low end passes the edge, one on the high end does not: rows stand off upwards.
    for (std::int64_t y = std::max<std::int64_t>(lattice.firstFrom(at(low, 1)), 0); y < end; ++y) {
        const Int128 ahead = offset + (lattice.at(static_cast<int>(y)) - at(low, 1)) * dx;
        const Int128 steps = ahead <= 0 ? -(-ahead / step) : (ahead + step - 1) / step;
        const std::int64_t sample = base + static_cast<std::int64_t>(steps);
        alongX_.push_back(
            {y, sample, up ? labels.inner : labels.outer, up ? labels.outer : labels.inner});
    }
}

std::vector<Windings> OpenBorder::below(int xBegin, int count, int y) const {
    Windings now(corner_);
    std::vector<Windings> windings;
    for (const Pass& pass : alongY_) {
        if (pass.sample > y) break;
        now.pass(pass.from, pass.to);
    }
    const auto line = [](const Pass& pass, int row) { return pass.line < row; };
    auto pass = std::lower_bound(alongX_.begin(), alongX_.end(), y, line);
    for (int x = xBegin; x < xBegin + count; ++x) {
        for (; pass != alongX_.end() && pass->line == y && pass->sample <= x; ++pass)
            now.pass(pass->from, pass->to);
        windings.push_back(now);
    }
    return windings;
}

}  // namespace rivage::core
