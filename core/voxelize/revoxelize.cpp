#include "core/voxelize/revoxelize.h"

#include "core/voxelize/coarsen.h"
#include "core/voxelize/label_columns.h"
#include "core/voxelize/resample.h"
#include "core/voxelize/topology.h"

namespace rivage::core {
namespace {

Vec3i scaledOrigin(const Vec3i& origin, const Scale& scale) {
    Vec3i scaled;
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t times = std::int64_t{origin[axis]} * scale.up;
        const std::int64_t cut = times / scale.down;
        scaled[axis] = static_cast<int>(times % scale.down < 0 ? cut - 1 : cut);
    }
    return scaled;
}

Result<void> compareTopology(const VoxelGrid& before, const VoxelGrid& after, const RunContext& run,
                             VoxelReport& report) {
    const auto was = labelTopology(before, run);
    if (!was) return fail(was.error());
    const auto is = labelTopology(after, run);
    if (!is) return fail(is.error());
    for (std::size_t i = 0; i < was->size(); ++i) report.topology.push_back({(*was)[i], (*is)[i]});
    return {};
}

}  // namespace

Vec3i scaledSize(const Vec3i& grid, const Scale& scale) {
    return SampleLattice::over(grid, scale.up, scale.down).size;
}

Result<VoxelGrid> revoxelize(const VoxelGrid& grid, const DigitalSurface& surface,
                             const IdVector<PointelId, Vec3d>& positions, const Scale& scale,
                             const RunContext& run, VoxelReport& report) {
    const auto moved = snapSurface(surface, positions, run);
    if (!moved) return fail(moved.error());
    const auto nearest = NearestSurfel::build(*moved, grid.voxels.size(), run);
    if (!nearest) return fail(nearest.error());
    const bool coarser = scale.up < scale.down;
    const Vec3i size = scaledSize(grid.voxels.size(), scale);
    const SampleLattice lattice =
        coarser ? samplesFor(size, scale) : SampleLattice{scale.up, scale.down, size};
    const auto columns = scanLabels(grid, *moved, *nearest, lattice, run);
    if (!columns) return fail(columns.error());
    run.report(Stage::mesh, 0.5);
    auto result = coarser ? coarsen(grid, *nearest, *columns, size, run, report)
                          : resample(grid, *nearest, *columns, run);
    if (!result) return result;
    result->origin = scaledOrigin(grid.origin, scale);
    report.dims = {size.x(), size.y(), size.z()};
    report.folded = columns->folded();
    if (coarser)
        if (const auto done = compareTopology(grid, *result, run, report); !done)
            return fail(done.error());
    return result;
}

}  // namespace rivage::core
