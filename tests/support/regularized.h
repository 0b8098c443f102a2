#pragma once

#include "core/base/options.h"
#include "core/energy/energy.h"
#include "core/grid/voxel_grid.h"
#include "core/mesh/inverted.h"
#include "core/normals/normal_field.h"
#include "core/solve/minimize.h"
#include "core/surface/digital_surface.h"
#include "core/surface/split_umbrellas.h"

namespace rivage::test {

using namespace rivage::core;

/// A grid's surface with its regularized positions: the middle of the pipeline, for tests that
/// look at positions instead of meshes.
struct Regularized {
    DigitalSurface surface;
    PointelVectors positions;
};

inline Regularized regularize(const VoxelGrid& grid, const MethodOptions& options,
                              const RunContext& run = {}) {
    Regularized result{*extractSurface(grid, run), {}};
    const SurfelLinks links = *linkSurfels(result.surface, run);
    if (options.energy.split) (void)*splitUmbrellas(result.surface, links, run);
    const Energy energy(
        result.surface, *estimateNormals(grid, result.surface, links, options.normals, run),
        EnergyWeights::uniform(result.surface, options.energy), options.energy, run.threads);
    result.positions = minimize(energy, options.solve, run)->positions;
    if (options.solve.untangle) untangle(result.surface, result.positions, run);
    return result;
}

}  // namespace rivage::test
