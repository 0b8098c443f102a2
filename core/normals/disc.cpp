#include "core/normals/disc.h"

#include <algorithm>

namespace rivage::core {

Disc DiscSums::disc(const DigitalSurface& surface, double radius, const Vec3d& fallback) const {
    Eigen::Array<double, 16, 1> mean =
        plain_.cast<double>() - timesDistance_.cast<double>() / radius;
    mean /= mean[0];
    const Vec3d area = mean.segment<3>(1);
    constexpr double kCancelled = 1e-9;
    Disc disc;
    disc.coherence = area.lpNorm<1>();
    disc.normal = area.norm() > kCancelled ? Vec3d(area.normalized()) : fallback;
    const Vec3d& n = disc.normal;
    const double square =
        mean[8] * n.x() * n.x() + mean[9] * n.y() * n.y() + mean[10] * n.z() * n.z() +
        2 * (mean[12] * n.x() * n.y() + mean[13] * n.x() * n.z() + mean[14] * n.y() * n.z());
    const double height = mean.segment<3>(4).matrix().dot(n);
    // The centres of a digital plane fill a slab of this width evenly.
    const double width = n.cwiseAbs().dot(surface.spacing);
    disc.flatness = 12 * std::max(0.0, square - height * height) / (width * width);
    return disc;
}

}  // namespace rivage::core
