#include <algorithm>
#include <cmath>

#include "core/samples/sample_scenes.h"
#include "core/samples/samples.h"

namespace rivage::core {
namespace {

/// Sets the voxels whose centre lies inside a solid.
template <typename Solid>
Scene rasterize(const Solid& solid, const std::string& name, const Rgba8& color) {
    Scene scene = emptySample(solid.size, name);
    const MaterialId material = addPaletteRow(scene, {.name = name}, {color});
    for (int z = 0; z < solid.size.z(); ++z)
        for (int y = 0; y < solid.size.y(); ++y)
            for (int x = 0; x < solid.size.x(); ++x)
                if (signedDistance(solid, Vec3d(x + 0.5, y + 0.5, z + 0.5)) < 0)
                    scene.models.front().set(Vec3i(x, y, z), material);
    return scene;
}

}  // namespace

Mat3d SampleBox::axes() const {
    constexpr double w = 9;
    constexpr double x = 2;
    constexpr double y = 3;
    constexpr double z = 4;
    Mat3d axes;
    axes << w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z;
    return axes / (w * w + x * x + y * y + z * z);
}

double signedDistance(const SampleSphere& sphere, const Vec3d& point) {
    return (point - sphere.center).norm() - sphere.radius;
}

double signedDistance(const SampleTorus& torus, const Vec3d& point) {
    const Vec3d p = point - torus.center;
    const double ring = std::sqrt(p.x() * p.x() + p.y() * p.y()) - torus.majorRadius;
    return std::sqrt(ring * ring + p.z() * p.z()) - torus.minorRadius;
}

double signedDistance(const SampleBox& box, const Vec3d& point) {
    const Vec3d local = box.axes().transpose() * (point - box.center);
    const Vec3d excess = local.cwiseAbs() - box.halfSides;
    return excess.cwiseMax(0).norm() + std::min(0.0, excess.maxCoeff());
}

Scene makeSphere() { return rasterize(SampleSphere{}, "sphere", {214, 106, 82, 255}); }
Scene makeTorus() { return rasterize(SampleTorus{}, "torus", {86, 150, 196, 255}); }
Scene makeRotatedBox() { return rasterize(SampleBox{}, "rotated_box", {226, 178, 84, 255}); }

}  // namespace rivage::core
