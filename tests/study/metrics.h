#pragma once

#include <array>
#include <limits>
#include <string_view>
#include <vector>

#include "tests/study/methods.h"
#include "tests/support/shapes.h"

/// How far a mesh is from the shape that was digitized, and what is wrong with it.
namespace rivage::study {

using namespace rivage::test;

enum class Measure : std::uint8_t {
    rms,   ///< vertices to the true interface, voxels; the farthest of the interfaces that
    mean,  ///< meet in a vertex counts
    max,
    bias,        ///< signed mean; negative: towards the inner label
    hausdorff,   ///< the larger of `max` and of the distances of samples of the true surface
    normalMean,  ///< faces to the true normal, degrees, weighted by area
    normal95,    ///< 95 % of the area is below
    nearCrease,  ///< as `normalMean`, of faces 1 to 3 voxels from a crease or junction
    farCrease,   ///< of those further away
    estimate,    ///< mean error of the normals that the method was given, degrees
    volume,      ///< sum over the labels of |volume - voxels|, percent of all voxels
    inverted,    ///< corners more than a right angle from the true normal, percent
    degenerate,  ///< faces below 2 % of their area on the lattice, percent
    crossing,    ///< pairs of faces without a common vertex that intersect
    wrong,       ///< voxel centres that the surface gives another label than the grid
    untrue,      ///< voxel centres that the surface gives another label than the true shape
    faces
};
inline constexpr std::size_t kMeasures = static_cast<std::size_t>(Measure::faces) + 1;
inline constexpr std::array<std::string_view, kMeasures> kMeasureNames = {
    "rms",   "mean",   "max",      "bias",       "hausdorff",    "normal_mean",    "normal_95",
    "near",  "far",    "estimate", "volume_pct", "inverted_pct", "degenerate_pct", "crossing",
    "wrong", "untrue", "faces"};

struct Measures {
    std::array<double, kMeasures> values;
    Measures() { values.fill(std::numeric_limits<double>::quiet_NaN()); }
    [[nodiscard]] double& operator[](Measure m) { return values[static_cast<std::size_t>(m)]; }
    [[nodiscard]] double operator[](Measure m) const { return values[static_cast<std::size_t>(m)]; }
};

struct MeasureOptions {
    bool bothWays = false;      ///< hausdorff too
    bool thorough = false;      ///< crossing and wrong too; with `clean`: untrue instead
    std::size_t leastPart = 1;  ///< parts that hang together by edges with fewer faces are left out
    const VoxelGrid* clean = nullptr;  ///< the grid without label noise, for `untrue`
};

/// Figures that a method has no meaning for stay NaN.
[[nodiscard]] Measures measure(const Shape& shape, const Outcome& outcome,
                               const MeasureOptions& options);

/// Greatest distance of points from a mesh; looks no further than 8 voxels.
[[nodiscard]] double farthestFrom(const StudyMesh& mesh, const std::vector<Vec3d>& points);

}  // namespace rivage::study
