#pragma once

#include <algorithm>

#include "core/normals/normal_field.h"
#include "core/solve/minimize.h"
#include "tests/support/grids.h"

namespace rivage::test {

/// A surface, changed by hand if need be, with its normals and energy: everything before the
/// solver.
struct PreparedSurface {
    VoxelGrid grid;
    DigitalSurface surface;
    EnergyOptions options;
    NormalField normals;

    template <typename Change>
    PreparedSurface(VoxelGrid g, const EnergyOptions& energyOptions, Change&& change)
        : grid(std::move(g)),
          surface(*extractSurface(grid, {})),
          options(energyOptions),
          normals(*estimateNormals(grid, surface, *linkSurfels(surface, {}), {}, {})) {
        change(surface);
    }
    [[nodiscard]] Energy energy(int threads = 1) const {
        return {surface, normals, EnergyWeights::uniform(surface, options), options, threads};
    }
};

inline double largestDifference(const PointelVectors& a, const PointelVectors& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, (a.raw()[i] - b.raw()[i]).cwiseAbs().maxCoeff());
    return largest;
}

}  // namespace rivage::test
