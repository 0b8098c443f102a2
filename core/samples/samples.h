#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/vec.h"
#include "core/grid/scene.h"

/// Scenes that the project makes itself: for the demo, the tests and the accuracy study. All are
/// the same on every machine.
namespace rivage::core {

struct SampleInfo {
    std::string_view name;
    std::string_view what;  ///< one sentence
    LabelMode labels;       ///< the label mode that shows the labels it was made for
};

/// Every sample, the demo's first.
[[nodiscard]] const std::vector<SampleInfo>& sampleInfos();

/// A sample as a scene of one model with its material table.
/// @errors notFound if no sample has this name
Result<Scene> makeSample(const std::string& name);

/// Scene coordinates of voxel (0, 0, 0) of a sample: it stands on the ground, and the middle of its
/// floor, rounded down, is the origin.
[[nodiscard]] inline Vec3i sampleOrigin(const Vec3i& size) {
    return {-(size.x() / 2), -(size.y() / 2), 0};
}

/// The solids behind the analytic samples, in the coordinates of their model (voxel (0, 0, 0) is
/// [0,1]^3, `size` the whole model): a voxel is set if its centre lies inside. A point p of the
/// model is the point p + sampleOrigin(size) of the scene.
struct SampleSphere {
    Vec3d center = Vec3d(15.1, 14.9, 15.3);
    double radius = 12.3;
    Vec3i size = Vec3i(30, 30, 30);
};
struct SampleTorus {
    Vec3d center = Vec3d(24.2, 23.9, 9.1);
    double majorRadius = 15.6;  ///< around the z axis
    double minorRadius = 6.2;
    Vec3i size = Vec3i(48, 48, 18);
};
struct SampleBox {
    Vec3d center = Vec3d(20.3, 20.1, 19.8);
    Vec3d halfSides = Vec3d(13.2, 9.1, 7.4);
    /// Columns: the unit axes of the box, from the unit quaternion (w, x, y, z) = (9, 2, 3, 4) /
    /// sqrt(110), so that no face lies along the grid.
    [[nodiscard]] Mat3d axes() const;
    Vec3i size = Vec3i(40, 40, 40);
};
/// Distance of a point to the surface of the solid, negative inside.
[[nodiscard]] double signedDistance(const SampleSphere& sphere, const Vec3d& point);
[[nodiscard]] double signedDistance(const SampleTorus& torus, const Vec3d& point);
[[nodiscard]] double signedDistance(const SampleBox& box, const Vec3d& point);

}  // namespace rivage::core
