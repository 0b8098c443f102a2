#include "tests/support/walls.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rivage::test {

namespace {

constexpr int kSide = 20;
constexpr double kMargin = 4;  // from the border, where faces lack neighbours

class SideStatistics {
public:
    void add(double height, double error) {
        ++count_;
        sum_ += height;
        squares_ += height * height;
        errors_ += error;
    }
    [[nodiscard]] double mean() const { return sum_ / count_; }
    [[nodiscard]] double variance() const {
        return std::max(0.0, squares_ / count_ - mean() * mean());
    }
    [[nodiscard]] double error() const { return errors_ / count_; }

private:
    double count_ = 0;
    double sum_ = 0;
    double squares_ = 0;
    double errors_ = 0;
};

}  // namespace

const std::vector<Vec3i>& wallNormals() {
    static const std::vector<Vec3i> all = {{0, 0, 1}, {1, 1, 0}, {1, 1, 1}, {2, 1, 0},
                                           {1, 2, 3}, {3, 3, 1}, {3, 2, 2}, {5, 3, 1}};
    return all;
}

VoxelGrid wallGrid(const Vec3i& normal) {
    const int middle = (kSide / 2) * normal.sum();
    VoxelGrid grid = makeGrid(Vec3i::Constant(kSide), 1, [&](const Vec3i& v) {
        const int height = v.dot(normal) - middle;
        return height >= 0 && height < normal.maxCoeff() ? 1 : 0;
    });
    grid.openBorder = true;
    return grid;
}

Sides measureSides(const Regularized& result, const Vec3i& normal) {
    const Vec3d unit = normal.cast<double>().normalized();
    std::array<SideStatistics, 2> sides;
    for (std::uint32_t i = 0; i < result.surface.surfelCount(); ++i) {
        const SurfelId s{i};
        const Vec3d rest = result.surface.centre(s);
        if (rest.minCoeff() < kMargin || rest.maxCoeff() > kSide - kMargin) continue;
        const auto& c = result.surface.corners[s];
        const auto& x = result.positions;
        const Vec3d across = (x[c[2]] - x[c[0]]).cross(x[c[3]] - x[c[1]]).normalized();
        const bool upper = result.surface.trivialNormal(s).dot(normal) > 0;
        const double cosine = std::min(1.0, across.dot(upper ? unit : Vec3d(-unit)));
        const double height = 0.25 * (x[c[0]] + x[c[1]] + x[c[2]] + x[c[3]]).dot(unit);
        sides[upper ? 1 : 0].add(height, std::acos(cosine) * 180 / M_PI);
    }
    return {sides[1].mean() - sides[0].mean(),
            std::sqrt(0.5 * (sides[0].variance() + sides[1].variance())),
            0.5 * (sides[0].error() + sides[1].error())};
}

}  // namespace rivage::test
