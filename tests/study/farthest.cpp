#include <algorithm>
#include <cmath>

#include "tests/study/metrics.h"

namespace rivage::study {
namespace {

using Triangle = std::array<Vec3d, 3>;

Vec3d nearestOnSegment(const Vec3d& a, const Vec3d& b, const Vec3d& p) {
    const Vec3d along = b - a;
    const double length2 = along.squaredNorm();
    if (length2 == 0) return a;
    return a + std::clamp((p - a).dot(along) / length2, 0.0, 1.0) * along;
}

double squaredDistance(const Triangle& t, const Vec3d& p) {
    const Vec3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
    const bool flat = normal.squaredNorm() < 1e-24;
    bool inside = !flat;
    for (std::size_t k = 0; k < 3 && inside; ++k)
        inside = normal.dot((t[(k + 1) % 3] - t[k]).cross(p - t[k])) >= 0;
    if (inside) return std::pow(normal.dot(p - t[0]), 2) / normal.squaredNorm();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k)
        least = std::min(least, (p - nearestOnSegment(t[k], t[(k + 1) % 3], p)).squaredNorm());
    return least;
}

/// Triangles by the unit cells that their bounding boxes meet.
class TriangleGrid {
public:
    explicit TriangleGrid(const StudyMesh& mesh) {
        Vec3d low = Vec3d::Constant(1e9);
        Vec3d high = -low;
        for (const Face& face : mesh.faces)
            for (const Triangle& t : trianglesOf(mesh, face)) {
                triangles_.push_back(t);
                for (const Vec3d& x : t) {
                    low = low.cwiseMin(x);
                    high = high.cwiseMax(x);
                }
            }
        // Vertices that flew away share the cells of the border.
        origin_ = low.cwiseMax(-kMargin).array().floor().matrix().cast<int>();
        const Vec3i end = high.cwiseMin(kLargest).array().floor().matrix().cast<int>();
        size_ = (end - origin_ + Vec3i::Ones()).cwiseMax(1);
        cells_.resize(static_cast<std::size_t>(size_.x()) * size_.y() * size_.z());
        for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
            const Triangle& t = triangles_[i];
            const Vec3i from = cellOf(t[0].cwiseMin(t[1]).cwiseMin(t[2]));
            const Vec3i to = cellOf(t[0].cwiseMax(t[1]).cwiseMax(t[2]));
            forCells(from, to, [&](std::size_t cell) { cells_[cell].push_back(i); });
        }
    }

    /// Distance of a point, or something below `enough` if it is below that.
    [[nodiscard]] double distance(const Vec3d& p, double enough) const {
        const Vec3i at = cellOf(p);
        double least = std::numeric_limits<double>::infinity();
        for (int reach = 1; reach <= kReach; ++reach) {
            forCells(at - Vec3i::Constant(reach), at + Vec3i::Constant(reach),
                     [&](std::size_t cell) {
                         for (const std::uint32_t i : cells_[cell])
                             least = std::min(least, squaredDistance(triangles_[i], p));
                     });
            // Whatever is in no cell looked at is at least `reach` away.
            if (least <= std::max(static_cast<double>(reach) * reach, enough * enough)) break;
        }
        return std::min(std::sqrt(least), static_cast<double>(kReach));
    }

private:
    static constexpr int kReach = 8;
    static inline const Vec3d kMargin = Vec3d::Constant(16);
    static inline const Vec3d kLargest = Vec3d::Constant(300);

    [[nodiscard]] Vec3i cellOf(const Vec3d& p) const {
        const Vec3d bounded = p.cwiseMax(-2 * kMargin).cwiseMin(2 * kLargest);
        const Vec3i cell = bounded.array().floor().matrix().cast<int>() - origin_;
        return cell.cwiseMax(0).cwiseMin(size_ - Vec3i::Ones());
    }
    template <typename Visit>
    void forCells(const Vec3i& from, const Vec3i& to, Visit&& visit) const {
        const Vec3i low = from.cwiseMax(0);
        const Vec3i high = to.cwiseMin(size_ - Vec3i::Ones());
        for (int z = low.z(); z <= high.z(); ++z)
            for (int y = low.y(); y <= high.y(); ++y)
                for (int x = low.x(); x <= high.x(); ++x)
                    visit((static_cast<std::size_t>(z) * size_.y() + y) * size_.x() + x);
    }

    Vec3i origin_;
    Vec3i size_;
    std::vector<Triangle> triangles_;
    std::vector<std::vector<std::uint32_t>> cells_;
};

}  // namespace

double farthestFrom(const StudyMesh& mesh, const std::vector<Vec3d>& points) {
    const TriangleGrid grid(mesh);
    double farthest = 0;
    for (const Vec3d& point : points) farthest = std::max(farthest, grid.distance(point, farthest));
    return farthest;
}

}  // namespace rivage::study
