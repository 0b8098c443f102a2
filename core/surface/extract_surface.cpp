#include <algorithm>
#include <numeric>
#include <string>

#include "core/base/parallel.h"
#include "core/surface/digital_surface.h"
#include "core/surface/interfaces.h"
#include "core/surface/row_scan.h"

namespace rivage::core {
namespace {

/// Where the pointels and surfels of each row (y, z) of pointels begin.
struct RowTable {
    int rowsY = 0;
    int rowsZ = 0;
    std::vector<std::uint64_t> pointels;  // rowsY * rowsZ + 1
    std::vector<std::uint64_t> surfels;

    explicit RowTable(const Vec3i& size)
        : rowsY(size.y() + 1),
          rowsZ(size.z() + 1),
          pointels(static_cast<std::size_t>(rowsY) * rowsZ + 1),
          surfels(pointels.size()) {}
    [[nodiscard]] std::size_t row(int y, int z) const {
        return static_cast<std::size_t>(z) * rowsY + y;
    }
};

/// Calls `visit(scan, y, z)` for every row of pointels that may hold one; one slab a task.
template <typename Visit>
bool forEachRow(const VoxelGrid& grid, const RowTable& rows, const RunContext& run, Visit&& visit) {
    constexpr std::size_t kSlabs = 4;
    const std::vector<bool> stored = grid.voxels.storedRows();
    constexpr int kPoll = 32;  // rows of up to 4096 voxels
    return parallelBlocks(rows.rowsZ, kSlabs, run, [&](std::size_t begin, std::size_t end) {
        RowScan scan(grid, stored);
        for (std::size_t z = begin; z < end; ++z)
            for (int y = 0; y < rows.rowsY; ++y) {
                if (y % kPoll == 0 && run.stopped()) return;
                scan.moveTo(y, static_cast<int>(z));
                if (scan.maybe()) visit(scan, y, static_cast<int>(z));
            }
    });
}

bool countRows(const VoxelGrid& grid, RowTable& rows, const RunContext& run) {
    const int nx = grid.voxels.size().x();
    const bool done = forEachRow(grid, rows, run, [&](const RowScan& scan, int y, int z) {
        std::uint64_t pointels = 0;
        std::uint64_t surfels = 0;
        for (int x = 0; x <= nx; ++x) {
            if (!scan.isPointel(x)) continue;
            ++pointels;
            surfels += static_cast<unsigned>(__builtin_popcount(scan.surfelAxesAt(x)));
        }
        rows.pointels[rows.row(y, z) + 1] = pointels;
        rows.surfels[rows.row(y, z) + 1] = surfels;
    });
    std::partial_sum(rows.pointels.begin(), rows.pointels.end(), rows.pointels.begin());
    std::partial_sum(rows.surfels.begin(), rows.surfels.end(), rows.surfels.begin());
    return done;
}

DigitalSurface allocate(const VoxelGrid& grid, const RowTable& rows) {
    DigitalSurface surface;
    surface.spacing = grid.spacing;
    const std::size_t n = rows.pointels.back();
    const std::size_t m = rows.surfels.back();
    surface.pointels.resize(n, Vec3i::Zero());
    std::array<PointelId, kSlots> noNeighbours;
    noNeighbours.fill(kNone<PointelId>);
    surface.neighbours.resize(n, noNeighbours);
    surface.firstSurfel.resize(n);
    surface.surfelAxes.resize(n);
    surface.junctionSlots.resize(n);
    if (grid.openBorder) surface.fixedAxes.resize(n);
    surface.resizeSurfels(m);
    return surface;
}

/// The background is always outer, otherwise the smaller label is inner.
bool lowIsInner(Label low, Label high) {
    return low != Label{0} && (high == Label{0} || low < high);
}

/// Everything about the surfels with lowest corner x but their corners.
void fillSurfels(DigitalSurface& surface, const RowScan& scan, int x, PointelId p) {
    constexpr std::array<RowScan::Row, 3> kLowRow = {RowScan::highYhighZ, RowScan::lowYhighZ,
                                                     RowScan::highYlowZ};
    const std::uint8_t axes = surface.surfelAxes[p];
    for (int axis = 0; axis < 3; ++axis) {
        if ((axes >> axis & 1) == 0) continue;
        const SurfelId s = surface.surfelAt(p, axis);
        const int lowX = axis == 0 ? x - 1 : x;
        const Label low = scan.label(kLowRow[axis], lowX);
        const Label high = scan.label(RowScan::highYhighZ, x);
        MaterialId inner = scan.material(kLowRow[axis], lowX);
        MaterialId outer = scan.material(RowScan::highYhighZ, x);
        const bool innerIsLow = lowIsInner(low, high);
        if (!innerIsLow) std::swap(inner, outer);
        surface.axis[s] = static_cast<std::uint8_t>(axis);
        surface.innerIsLow[s] = innerIsLow;
        surface.innerMaterial[s] = inner;
        surface.outerMaterial[s] = outer;
    }
}

/// Pointels with what the voxels around them tell. Slots of linels that are there get the id 0 as
/// a mark, but for -x and +x: those neighbours are next in the row.
bool fillRows(const VoxelGrid& grid, const RowTable& rows, DigitalSurface& surface,
              const RunContext& run) {
    const int nx = grid.voxels.size().x();
    return forEachRow(grid, rows, run, [&](const RowScan& scan, int y, int z) {
        const std::size_t row = rows.row(y, z);
        auto p = static_cast<std::uint32_t>(rows.pointels[row]);
        auto s = static_cast<std::uint32_t>(rows.surfels[row]);
        for (int x = 0; x <= nx; ++x) {
            if (!scan.isPointel(x)) continue;
            const PointelId id{p};
            const RowScan::Linels linels = scan.linelsAt(x);
            surface.pointels[id] = Vec3i(x, y, z);
            surface.junctionSlots[id] = linels.junction;
            surface.surfelAxes[id] = scan.surfelAxesAt(x);
            if (grid.openBorder) surface.fixedAxes[id] = scan.fixedAxesAt(x);
            surface.firstSurfel[id] = SurfelId{s};
            auto& slots = surface.neighbours[id];
            for (int slot = 2; slot < kSlots; ++slot)
                if (linels.present >> slot & 1) slots[slot] = PointelId{0};
            if (linels.present & 1) slots[0] = PointelId{p - 1};
            if (linels.present >> 1 & 1) slots[1] = PointelId{p + 1};
            fillSurfels(surface, scan, x, id);
            s += static_cast<std::uint32_t>(__builtin_popcount(surface.surfelAxes[id]));
            ++p;
        }
    });
}

/// Resolves the marked slots -y +y -z +z of one row: both rows are sorted by x, so one walk each.
void linkRow(const RowTable& rows, DigitalSurface& surface, int y, int z) {
    const std::array<std::array<int, 2>, 4> offsets = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    const std::size_t row = rows.row(y, z);
    for (int k = 0; k < 4; ++k) {
        const int slot = k + 2;
        const int otherY = y + offsets[k][0];
        const int otherZ = z + offsets[k][1];
        if (otherY < 0 || otherZ < 0 || otherY >= rows.rowsY || otherZ >= rows.rowsZ) continue;
        auto other = static_cast<std::uint32_t>(rows.pointels[rows.row(otherY, otherZ)]);
        for (std::uint64_t i = rows.pointels[row]; i < rows.pointels[row + 1]; ++i) {
            const PointelId p{static_cast<std::uint32_t>(i)};
            if (surface.neighbours[p][slot] == kNone<PointelId>) continue;
            while (surface.pointels[PointelId{other}].x() < surface.pointels[p].x()) ++other;
            surface.neighbours[p][slot] = PointelId{other};
        }
    }
}

void fillCorners(DigitalSurface& surface, PointelId p) {
    for (int axis = 0; axis < 3; ++axis) {
        const SurfelId s = surface.surfelAt(p, axis);
        if (s == kNone<SurfelId>) continue;
        const int slotB = 2 * ((axis + 1) % 3) + 1;
        const int slotC = 2 * ((axis + 2) % 3) + 1;
        PointelId b = surface.neighbours[p][slotB];
        PointelId c = surface.neighbours[p][slotC];
        const PointelId opposite = surface.neighbours[b][slotC];
        if (surface.innerIsLow[s] == 0) std::swap(b, c);
        surface.corners[s] = {p, b, opposite, c};
    }
}

}  // namespace

Vec3i DigitalSurface::innerVoxel(SurfelId s) const {
    const Vec3i high = pointels[corners[s][0]];
    return innerIsLow[s] ? Vec3i(high - Vec3i::Unit(axis[s])) : high;
}

Vec3i DigitalSurface::outerVoxel(SurfelId s) const {
    const Vec3i high = pointels[corners[s][0]];
    return innerIsLow[s] ? high : Vec3i(high - Vec3i::Unit(axis[s]));
}

Result<SurfaceSize> countSurface(const VoxelGrid& grid, const RunContext& run) {
    RowTable rows(grid.voxels.size());
    if (!countRows(grid, rows, run)) return fail(run.stopError());
    return SurfaceSize{rows.pointels.back(), rows.surfels.back()};
}

Result<DigitalSurface> extractSurface(const VoxelGrid& grid, const RunContext& run) {
    RowTable rows(grid.voxels.size());
    if (!countRows(grid, rows, run)) return fail(run.stopError());
    constexpr std::uint64_t kMaxCells = 0xfffffffe;  // the last id means "none"
    if (const auto cells = std::max(rows.pointels.back(), rows.surfels.back()); cells > kMaxCells)
        return fail(Error{ErrorCode::tooLarge,
                          "the digital surface has " + std::to_string(cells) + " cells", "/grid",
                          kMaxCells, cells});

    DigitalSurface surface = allocate(grid, rows);
    if (!fillRows(grid, rows, surface, run)) return fail(run.stopError());
    const bool linked =
        parallelFor(static_cast<std::size_t>(rows.rowsY) * rows.rowsZ, run, [&](std::size_t row) {
            linkRow(rows, surface, static_cast<int>(row % rows.rowsY),
                    static_cast<int>(row / rows.rowsY));
        });
    if (!linked || !parallelFor(surface.pointelCount(), run, [&](std::size_t p) {
            fillCorners(surface, PointelId{static_cast<std::uint32_t>(p)});
        }))
        return fail(run.stopError());
    if (!groupInterfaces(grid, surface, run)) return fail(run.stopError());
    return surface;
}

}  // namespace rivage::core
