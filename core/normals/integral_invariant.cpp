#include "core/normals/integral_invariant.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace rivage::core {
namespace {

/// From the centre of a surfel to the centre of a voxel, relative to the voxel at its low corner.
Vec3d fromCentre(const Vec3i& voxel, int axis, const Vec3d& spacing) {
    return (voxel.cast<double>() + 0.5 * Vec3d::Unit(axis)).cwiseProduct(spacing);
}

std::vector<Vec3i> voxelsOfBall(double radius, int axis, const Vec3d& spacing) {
    const int reach = static_cast<int>(std::ceil(radius)) + 1;
    std::vector<Vec3i> voxels;
    for (int z = -reach; z <= reach; ++z)
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x)
                if (fromCentre({x, y, z}, axis, spacing).squaredNorm() <= radius * radius)
                    voxels.emplace_back(x, y, z);
    return voxels;
}

/// Moments of a set of voxels relative to the centre of a surfel.
struct Moments {
    double count = 0;
    Vec3d first = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();

    void add(const Vec3d& at) {
        ++count;
        first += at;
        second += at * at.transpose();
    }
    [[nodiscard]] Mat3d covariance() const { return second - first * first.transpose() / count; }
};

}  // namespace

IntegralInvariant::IntegralInvariant(const VoxelGrid& grid, const DigitalSurface& surface,
                                     double radius)
    : grid_(grid), surface_(surface), radius_(radius) {
    for (int axis = 0; axis < 3; ++axis) ball_[axis] = voxelsOfBall(radius, axis, surface.spacing);
}

Vec3d IntegralInvariant::normal(SurfelId s, PatchWalker& walker) const {
    const LabelPair labels = surface_.interfaces[surface_.interfaceOf[s]].labels;
    const int axis = surface_.axis[s];
    const Vec3i& corner = surface_.pointels[surface_.corners[s][0]];
    Moments inner;
    Moments outer;
    for (const Vec3i& voxel : ball_[axis]) {
        const Vec3i at = corner + voxel;
        if (grid_.openBorder && !grid_.voxels.contains(at))
            return convolvedNormal(surface_, walker, s, radius_);
        const Label label = grid_.labelAt(at);
        if (label == labels.inner)
            inner.add(fromCentre(voxel, axis, surface_.spacing));
        else if (label == labels.outer)
            outer.add(fromCentre(voxel, axis, surface_.spacing));
        else  // a third label, or what lies behind an open border
            return convolvedNormal(surface_, walker, s, radius_);
    }
    const Moments& thinner = inner.count <= outer.count ? inner : outer;
    Eigen::SelfAdjointEigenSolver<Mat3d> eigen(thinner.covariance());
    const Vec3d direction = eigen.eigenvectors().col(0);
    // The first moments tell the side even where the trivial normal is nearly tangent.
    const Vec3d outwards = outer.first - inner.first;
    return direction.dot(outwards) < 0 ? Vec3d(-direction) : direction;
}

}  // namespace rivage::core
