#include "core/normals/disc.h"

#include <algorithm>

namespace rivage::core {

void DiscSums::add(const DigitalSurface& surface, SurfelId s, const Vec3d& offset,
                   double distance) {
    const int axis = surface.axis[s];
    const auto area = static_cast<float>(surface.faceArea(axis));
    const Eigen::Array3f at = offset.cast<float>().array();
    const Eigen::Array3f weighted = area * at;
    Row row = Row::Zero();
    row[0] = area;
    row[1 + axis] = surface.innerIsLow[s] ? area : -area;
    row.segment<3>(4) = weighted;
    row.segment<3>(8) = weighted * at;
    row[12] = weighted.x() * at.y();
    row[13] = weighted.x() * at.z();
    row[14] = weighted.y() * at.z();
    plain_ += row;
    // In multiples of 1/256 all sums of a window are exact, so they do not depend on the order in
    // which it is walked: the estimate has every symmetry of the grid.
    constexpr float kSteps = 256;
    const auto rounded = static_cast<float>(static_cast<int>(distance * kSteps + 0.5)) / kSteps;
    timesDistance_ += rounded * row;
}

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
