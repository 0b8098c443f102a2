#include "core/normals/convolved.h"

namespace rivage::core {

Vec3d convolvedNormal(const DigitalSurface& surface, PatchWalker& walker, SurfelId s,
                      double radius) {
    Vec3d sum = Vec3d::Zero();
    double weights = 0;
    walker.walk(s, radius, [&](SurfelId g, const Vec3d&, double distance) {
        const double weight = (1 - distance / radius) * surface.faceArea(surface.axis[g]);
        sum[surface.axis[g]] += surface.innerIsLow[g] ? weight : -weight;
        weights += weight;
    });
    constexpr double kCancelled = 1e-9;
    if (sum.norm() <= kCancelled * weights) return surface.trivialNormal(s).cast<double>();
    return sum.normalized();
}

}  // namespace rivage::core
