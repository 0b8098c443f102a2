#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/surface/digital_surface.h"
#include "tests/support/grids.h"

/// Shapes whose surface is known, to measure estimated normals and regularized positions against.
namespace rivage::test {

/// A voxelized shape. The functions take the label pair of an interface and a point near it, in
/// voxel units of the grid.
struct Shape {
    using Scalar = std::function<double(const LabelPair&, const Vec3d&)>;
    using Vector = std::function<Vec3d(const LabelPair&, const Vec3d&)>;
    using Predicate = std::function<bool(const LabelPair&, const Vec3d&)>;

    std::string name;
    VoxelGrid grid;
    Scalar distance;     ///< to the true interface; negative on the inner side
    Vector normal;       ///< of the true interface, inner to outer
    Scalar edge;         ///< distance to the nearest crease or border of the interface, or infinite
    Predicate measured;  ///< whether this place counts
};

[[nodiscard]] Shape sphereShape();                       ///< the sample: radius 12.3
[[nodiscard]] Shape sectorsShape();                      ///< a ball of radius 16 in 3 labels
[[nodiscard]] Shape sampleBoxShape();                    ///< the sample `rotated_box`
[[nodiscard]] Shape randomBoxShape(std::uint32_t seed);  ///< as large, turned and moved at random
[[nodiscard]] Shape cappedBallShape();    ///< radius 14, cut by a plane: a curved crease
[[nodiscard]] Shape torusShape();         ///< the sample
[[nodiscard]] Shape cubeShape(int side);  ///< along the grid, which it fills

/// `ballsGrid`, measured far from junctions: where a ball faces the background, at least 3 voxels
/// outside the two others.
[[nodiscard]] Shape ballsShape(int side);

/// Voxels flipped by Kanungo's noise model, see `withLabelNoise` of grids.h.
[[nodiscard]] Shape withLabelNoise(Shape shape, double p, std::uint32_t seed);

}  // namespace rivage::test
