#include "client/compare/distance.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "client/compare/triangle_tree.h"
#include "glb_builder.h"

using namespace rivage::client;
using namespace rivage::client::test;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

DistanceSamples between(const std::vector<Shape>& a, const std::vector<Shape>& b,
                        unsigned threads = 2) {
    return measureDistance(surfaceOf(a), surfaceOf(b), {PartPair{}},
                           {.samples = 20'000, .tolerance = 1e-6, .threads = threads});
}

double meanOf(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

TEST_SUITE("client/compare") {
    TEST_CASE("measureDistance: two planes at distance d are at distance d everywhere") {
        const DistanceSamples samples = between({plane(4, 3, 0)}, {plane(4, 7, 0.25)});
        REQUIRE(samples.distances.size() == 20'000);
        for (const double distance : samples.distances)
            REQUIRE(distance == doctest::Approx(0.25).epsilon(1e-12));
        for (const double degrees : samples.degrees) REQUIRE(degrees < 1e-9);
        CHECK(samples.rows.front().farthest.distance == doctest::Approx(0.25));
    }

    TEST_CASE("measureDistance: a cube and the cube twice as large") {
        // From the small one every point is 0.5 away from its side; from the large one a point of
        // a side is 0.5 away over the small side, and the corners sqrt(3)/2.
        const DistanceSamples out = between({cube(0.5, 1.5)}, {cube(0, 2)});
        for (const double distance : out.distances)
            REQUIRE(distance == doctest::Approx(0.5).epsilon(1e-12));
        const DistanceSamples in = between({cube(0, 2)}, {cube(0.5, 1.5)});
        CHECK(in.rows.front().farthest.distance == doctest::Approx(std::sqrt(3) / 2));
        const Vector3d at = in.rows.front().farthest.at;
        for (int i = 0; i < 3; ++i) CHECK(std::abs(at[i] - 1) == doctest::Approx(1));
        // A quarter of the area is over the small side, a half over its edges, a quarter over its
        // corners: the mean over a side of sqrt(0.25 + u^2 + v^2) with u, v beyond the small side.
        double expected = 0;
        const int n = 400;
        for (int x = 0; x < n; ++x)
            for (int y = 0; y < n; ++y) {
                const double u = std::max(0.0, std::abs((x + 0.5) * 2 / n - 1) - 0.5);
                const double v = std::max(0.0, std::abs((y + 0.5) * 2 / n - 1) - 0.5);
                expected += std::sqrt(0.25 + u * u + v * v) / n / n;
            }
        CHECK(meanOf(in.distances) == doctest::Approx(expected).epsilon(1e-3));
    }

    TEST_CASE("measureDistance: a ball against itself moved by d") {
        // The farthest point is d away; the mean of |d cos| over the ball is d/2.
        const double d = 0.01;
        const Shape still = ball({0, 0, 0}, 1, 100);
        const DistanceSamples samples =
            between({still}, {shifted(still, Vector3f(0, 0, static_cast<float>(d)))});
        CHECK(samples.rows.front().farthest.distance == doctest::Approx(d).epsilon(0.01));
        CHECK(std::abs(samples.rows.front().farthest.at.z()) == doctest::Approx(1).epsilon(0.01));
        CHECK(meanOf(samples.distances) == doctest::Approx(d / 2).epsilon(0.02));
    }

    TEST_CASE("measureDistance: a surface against itself, its order and its faces changed") {
        Shape mixed = ball({0, 0, 0}, 1, 20);
        std::reverse(mixed.triangles.begin(), mixed.triangles.end());
        const DistanceSamples same = between({ball({0, 0, 0}, 1, 20)}, {mixed});
        CHECK(same.rows.front().farthest.distance < 1e-12);
        CHECK(*std::max_element(same.degrees.begin(), same.degrees.end()) < 1e-5);
        const DistanceSamples turn = between({mixed}, {turned(mixed)});
        CHECK(turn.rows.front().farthest.distance < 1e-12);
        CHECK(*std::min_element(turn.degrees.begin(), turn.degrees.end()) > 100);
    }

    TEST_CASE("measureDistance: of two sheets at the same place the one with our normal counts") {
        const DistanceSamples samples =
            between({plane(1, 4, 0)}, {turned(plane(1, 3, 0)), plane(1, 2, 0)});
        CHECK(*std::max_element(samples.degrees.begin(), samples.degrees.end()) < 1e-9);
    }

    TEST_CASE("measureDistance: a place that only vertices reach is found") {
        Shape spike = plane(10, 10, 0);
        spike.positions[60].z() = 5;  // samples do not hit the very tip
        const DistanceSamples samples = between({spike}, {plane(10, 10, 0)});
        CHECK(samples.rows.front().farthest.distance == 5);
        CHECK(samples.rows.front().farthest.at == spike.positions[60].cast<double>());
    }

    TEST_CASE("measureDistance: samples are even by area") {
        // One large and many small triangles: the share of samples is that of the area.
        const std::vector<Shape> shapes{plane(3, 1, 0), shifted(plane(1, 30, 0), {10, 0, 0})};
        const DistanceSamples samples = between(shapes, {plane(3, 1, 0)});
        const auto far = std::count_if(samples.distances.begin(), samples.distances.end(),
                                       [](double distance) { return distance > 1; });
        CHECK(static_cast<double>(far) / 20'000 == doctest::Approx(0.1).epsilon(0.001));
    }

    TEST_CASE("measureDistance: colours differ where they were painted over") {
        const Shape red = painted(plane(1, 4, 0), {1, 0, 0});
        Shape half = red;
        half.colors.assign(half.positions.size(), Vector3f(1, 0, 0));
        Shape blue = shifted(painted(plane(1, 4, 0), {0, 0, 1}), {1, 0, 0});
        const Shape redThere = shifted(red, {1, 0, 0});
        const auto share = [](const DistanceSamples& samples) {
            return static_cast<double>(
                       std::count(samples.otherColor.begin(), samples.otherColor.end(), 1)) /
                   static_cast<double>(samples.otherColor.size());
        };
        CHECK(share(between({red, redThere}, {half, redThere})) == 0);
        CHECK(share(between({red, redThere}, {red, blue})) == doctest::Approx(0.5).epsilon(1e-3));
        CHECK(between({red}, {plane(1, 4, 0)}).otherColor.empty());
        // One step of 8 bits is what rounding may do; two are another colour.
        const Shape gray = painted(plane(1, 4, 0), Vector3f::Constant(0.5F));
        CHECK(share(between({gray}, {painted(gray, Vector3f::Constant(0.5035F))})) == 0);
        CHECK(share(between({gray}, {painted(gray, Vector3f::Constant(0.512F))})) == 1);
    }

    TEST_CASE("measureDistance: the farthest point is found where no sample and no vertex is") {
        // Over the middle of the gap between two points far below, in a triangle of its own.
        Shape floor = plane(1, 1, 0);
        Shape walls = shifted(plane(1, 1, 0), {100.37F, 0, 0});
        walls.positions.insert(walls.positions.end(), floor.positions.begin(),
                               floor.positions.end());
        const auto count = static_cast<std::uint32_t>(floor.positions.size());
        for (auto t : floor.triangles)
            walls.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
        Shape strip;
        strip.positions = {{0, 0.5F, 0}, {101.37F, 0.5F, 0}, {101.37F, 0.5001F, 0}};
        strip.triangles = {{0, 1, 2}};
        for (const std::size_t samples : {1, 400}) {
            const DistanceSamples found =
                measureDistance(surfaceOf({strip}), surfaceOf({walls}), {PartPair{}},
                                {.samples = samples, .tolerance = 1e-6});
            const Farthest& farthest = found.rows.front().farthest;
            CHECK(farthest.atMost >= (100.37F - 1) / 2 - 1e-4);
            if (samples == 1) continue;  // its searches are used up
            CHECK(farthest.distance == doctest::Approx((100.37 - 1) / 2).epsilon(0.005));
            CHECK(farthest.at.x() == doctest::Approx(101.37 / 2).epsilon(0.01));
            CHECK(farthest.atMost <= 1.0051 * farthest.distance);
        }
    }

    TEST_CASE("property: many random points are never farther than the bound") {
        const Shape a = ball({0, 0, 0}, 1, 7);
        const Shape b = shifted(cube(-0.7F, 0.8F), {0.2F, 0.1F, 0});
        const Farthest few = measureDistance(surfaceOf({a}), surfaceOf({b}), {PartPair{}},
                                             {.samples = 500, .tolerance = 1e-6})
                                 .rows.front()
                                 .farthest;
        const DistanceSamples many = measureDistance(surfaceOf({a}), surfaceOf({b}), {PartPair{}},
                                                     {.samples = 300'000, .tolerance = 1e-6});
        const double seen = *std::max_element(many.distances.begin(), many.distances.end());
        CHECK(seen <= few.atMost);
        CHECK(few.distance <= few.atMost);
        CHECK(few.atMost <= 1.006 * seen);
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same bits") {
        const Shape a = ball({0, 0, 0}, 1, 40);
        const Shape b = ball({0.1F, 0, 0}, 1.1F, 31);
        const DistanceSamples one = between({a}, {b}, 1);
        for (const unsigned threads : {2U, 7U}) {
            const DistanceSamples other = between({a}, {b}, threads);
            CHECK(one.distances == other.distances);
            CHECK(one.degrees == other.degrees);
            CHECK(one.rows.front().farthest.distance == other.rows.front().farthest.distance);
            CHECK(one.rows.front().farthest.at == other.rows.front().farthest.at);
        }
    }

    TEST_CASE("property: no sample of A is closer to B than the largest distance says") {
        const Shape a = ball({0, 0, 0}, 1, 12);
        const Shape b = cube(-1, 1);
        const DistanceSamples samples = between({a}, {b});
        CHECK(*std::max_element(samples.distances.begin(), samples.distances.end()) <=
              samples.rows.front().farthest.distance);
        // A ball of radius 1 in a cube of half side 1: the farthest is the diagonal, 1 - 1/sqrt(3).
        CHECK(samples.rows.front().farthest.distance ==
              doctest::Approx(1 - 1 / std::sqrt(3)).epsilon(0.02));
    }
}
