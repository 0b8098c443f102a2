#pragma once

#include <utility>

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
    SurfelLinks links;
    NormalField normals;
    int iterations = 0;  ///< of the solver
};

/// The surface of a grid as the normals are estimated on it; nothing has moved.
inline Regularized linkedSurface(const VoxelGrid& grid, const MethodOptions& options,
                                 const RunContext& run = {}) {
    Regularized result{.surface = *extractSurface(grid, run)};
    result.links = *linkSurfels(result.surface, run);
    if (options.energy.split) (void)*splitUmbrellas(result.surface, result.links, run);
    return result;
}

/// Moves the vertices to the minimum of the energy for `result.normals`.
inline void alignToNormals(Regularized& result, const MethodOptions& options,
                           const RunContext& run = {}) {
    const Energy energy(result.surface, result.normals,
                        EnergyWeights::uniform(result.surface, options.energy), options.energy,
                        run.threads);
    Solution solution = *minimize(energy, options.solve, run);
    result.iterations = solution.iterations;
    result.positions = std::move(solution.positions);
    if (options.solve.untangle) untangle(result.surface, result.positions, run);
}

inline Regularized regularize(const VoxelGrid& grid, const MethodOptions& options,
                              const RunContext& run = {}) {
    Regularized result = linkedSurface(grid, options, run);
    result.normals = *estimateNormals(grid, result.surface, result.links, options.normals, run);
    alignToNormals(result, options, run);
    return result;
}

}  // namespace rivage::test
