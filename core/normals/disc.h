#pragma once

#include <span>

#include "core/normals/patch_walker.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// What the surfels of a disc (a patch with hat weights 1 - distance / radius, times the area of a
/// surfel) say about the surface there.
struct Disc {
    Vec3d normal = Vec3d::Zero();  ///< mean of the trivial normals, unit
    /// |mean trivial normal|_1: 1 on a digital plane, below 0.55 at folds and thin parts.
    double coherence = 0;
    /// Variance of the centres along the normal over that of a digital plane: 0 to 0.5 on planes,
    /// 2 to 5 across a right angle at radius 4.
    double flatness = 0;

    static constexpr double kLeastCoherence = 0.55;
    [[nodiscard]] bool coherent() const { return coherence >= kLeastCoherence; }
};

/// Sums from which the disc of any radius follows: the weight 1 - d / t needs a sum and a sum
/// times d.
/// @source METHOD.md 3.1 (digital-plane identities)
class DiscSums {
public:
    void add(const DigitalSurface& surface, SurfelId s, const Vec3d& offset, double distance);
    /// @param radius    at least the largest distance that was added, and above 0
    /// @param fallback  the normal where the trivial normals cancel
    [[nodiscard]] Disc disc(const DigitalSurface& surface, double radius,
                            const Vec3d& fallback) const;

private:
    // weight, trivial normals (3), offsets (3), 0, squares of offsets (3), 0, xy xz yz, 0: float
    // and in fours, so that it adds up fast.
    using Row = Eigen::Array<float, 16, 1>;
    Row plain_ = Row::Zero();
    Row timesDistance_ = Row::Zero();
};

// Here, because estimators spend most of their time in it.
inline void DiscSums::add(const DigitalSurface& surface, SurfelId s, const Vec3d& offset,
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

/// The discs of growing radii around a surfel: calls `seen(scale, disc)`, which tells whether to go
/// on.
template <typename Seen>
void walkDiscs(const DigitalSurface& surface, PatchWalker& walker, SurfelId s,
               std::span<const double> radii, Seen&& seen) {
    const Vec3d trivial = surface.trivialNormal(s).cast<double>();
    DiscSums sums;
    walker.walkScales(
        s, radii,
        [&](SurfelId g, const Vec3d& offset, double distance) {
            sums.add(surface, g, offset, distance);
        },
        [&](std::size_t scale) { return seen(scale, sums.disc(surface, radii[scale], trivial)); });
}

}  // namespace rivage::core
