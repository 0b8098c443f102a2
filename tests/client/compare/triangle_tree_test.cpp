#include "client/compare/triangle_tree.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "glb_builder.h"

using namespace rivage::client;
using namespace rivage::client::test;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

std::vector<std::uint32_t> allOf(const Surface& surface) {
    std::vector<std::uint32_t> all;
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) all.push_back(t);
    return all;
}

/// Triangles of all sizes thrown about, slivers among them.
Surface randomSurface(std::mt19937& random, int count) {
    std::uniform_real_distribution<float> unit(-1, 1);
    Shape shape;
    const auto point = [&](float size) {
        return Vector3f(size * Vector3f(unit(random), unit(random), unit(random)));
    };
    for (int i = 0; i < count; ++i) {
        const float size = std::pow(10.0F, 2 * unit(random) - 1);
        const auto first = static_cast<std::uint32_t>(shape.positions.size());
        const Vector3f at = point(3);
        const Vector3f along = point(size);
        shape.positions.push_back(at);
        shape.positions.emplace_back(at + along);
        shape.positions.emplace_back(at + 0.5F * along + point(i % 5 == 0 ? 1e-4F * size : size));
        shape.triangles.push_back({first, first + 1, first + 2});
    }
    return surfaceOf({shape});
}

/// The closest point by the regions of the barycentric plane, another way than the code's.
double slowDistance(const Vector3d& p, const Triangle& t) {
    double best = 1e300;
    const int steps = 400;  // along each edge, then refined
    const Vector3d normal = areaNormal(t).normalized();
    const Vector3d foot = p - normal * normal.dot(p - t[0]);
    const auto side = [&](int i) { return (t[(i + 1) % 3] - t[i]).cross(foot - t[i]).dot(normal); };
    if (side(0) >= 0 && side(1) >= 0 && side(2) >= 0) return (p - foot).norm();
    for (int i = 0; i < 3; ++i) {
        double low = 0;
        double high = 1;
        const auto at = [&](double s) { return (t[i] + s * (t[(i + 1) % 3] - t[i]) - p).norm(); };
        for (int k = 0; k < steps; ++k) {  // the distance is convex along an edge
            const double a = low + (high - low) / 3;
            const double b = high - (high - low) / 3;
            if (at(a) < at(b))
                high = b;
            else
                low = a;
        }
        best = std::min({best, at(low), at(0), at(1)});
    }
    return best;
}

}  // namespace

TEST_SUITE("client/compare") {
    TEST_CASE("differential: the closest point of a triangle against bisection on its edges") {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> unit(-1, 1);
        const Surface surface = randomSurface(random, 300);
        for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
            const Triangle t = cornersOf(surface, i);
            const Vector3d p = t[0] + Vector3d(unit(random), unit(random), unit(random));
            const double fast = (closestOnTriangle(p, t) - p).norm();
            CHECK(fast == doctest::Approx(slowDistance(p, t)).epsilon(1e-6));
        }
    }

    TEST_CASE("differential: the tree finds what a loop over all triangles finds") {
        std::mt19937 random(11);
        std::uniform_real_distribution<double> unit(-4, 4);
        for (const int count : {1, 2, 5, 64, 1000}) {
            const Surface surface = randomSurface(random, count);
            const TriangleTree tree(surface, allOf(surface), 1e-9);
            TriangleTree::Search search;
            for (int i = 0; i < 500; ++i) {
                const Vector3d place(unit(random), unit(random), unit(random));
                double best2 = 1e300;
                for (std::size_t t = 0; t < surface.triangles.size(); ++t)
                    best2 = std::min(
                        best2,
                        (closestOnTriangle(place, cornersOf(surface, t)) - place).squaredNorm());
                tree.closest(place, search);
                REQUIRE(search.distance2 == best2);
                REQUIRE_FALSE(search.ties.empty());
            }
        }
    }

    TEST_CASE("differential: the ties are all triangles that are as close") {
        // Around a vertex of the grid six triangles meet, on an edge two.
        const Surface surface = surfaceOf({plane(8, 8, 0)});
        const TriangleTree tree(surface, allOf(surface), 1e-9);
        TriangleTree::Search search;
        const auto tiesAt = [&](const Vector3d& place) {
            tree.closest(place, search);
            std::set<std::uint32_t> ties;
            for (const auto& tie : search.ties) ties.insert(tie.triangle);
            CHECK(ties.size() == search.ties.size());
            return ties.size();
        };
        CHECK(tiesAt({3, 3, 0.5}) == 6);
        CHECK(tiesAt({3.5, 3, 0.5}) == 2);
        CHECK(tiesAt({3.6, 3.2, 0.5}) == 1);
        CHECK(tiesAt({-5, -5, 1}) == 2);
    }

    TEST_CASE("weightsIn: give the point back") {
        const Triangle t{Vector3d(0, 0, 0), Vector3d(2, 0, 0), Vector3d(0, 4, 1)};
        const Vector3d weights(0.2, 0.3, 0.5);
        const Vector3d point = 0.2 * t[0] + 0.3 * t[1] + 0.5 * t[2];
        CHECK((weightsIn(t, point) - weights).norm() < 1e-12);
        CHECK((weightsIn(t, t[1]) - Vector3d(0, 1, 0)).norm() < 1e-12);
    }
}
