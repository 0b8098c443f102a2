#include "core/voxelize/moved_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/voxelize/sample_lattice.h"

namespace rivage::core {

Vec3d MovedSurface::centre(SurfelId s) const {
    Vec3d sum = Vec3d::Zero();
    for (const PointelId p : surface.corners[s]) sum += positions[p];
    return (0.25 * sum).cwiseQuotient(surface.spacing);
}

Result<MovedSurface> snapSurface(const DigitalSurface& surface,
                                 const IdVector<PointelId, Vec3d>& positions,
                                 const RunContext& run) {
    constexpr double kReach = 131072.0 * kUnitsPerVoxel;  // fits 32 bits, far outside any grid
    MovedSurface moved{surface, positions, IdVector<PointelId, Vec3i>(positions.size())};
    const bool done = parallelFor(positions.size(), run, [&](std::size_t i) {
        const PointelId p{static_cast<std::uint32_t>(i)};
        const Vec3d units =
            positions[p].cwiseQuotient(surface.spacing) * static_cast<double>(kUnitsPerVoxel);
        for (int axis = 0; axis < 3; ++axis)
            moved.snapped[p][axis] =
                std::isfinite(units[axis])
                    ? static_cast<int>(std::lround(std::clamp(units[axis], -kReach, kReach)))
                    : std::numeric_limits<int>::max();
    });
    bool finite = true;
    const bool checked = serialFor(positions.size(), run, [&](std::size_t i) {
        const PointelId p{static_cast<std::uint32_t>(i)};
        finite = finite && moved.snapped[p].maxCoeff() < std::numeric_limits<int>::max();
    });
    if (!done || !checked) return fail(run.stopError());
    if (!finite) return fail(ErrorCode::internal, "a vertex has no finite position");
    return moved;
}

}  // namespace rivage::core
