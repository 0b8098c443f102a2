#include <doctest/doctest.h>

#include <filesystem>
#include <random>

#include "tests/study/bodies.h"
#include "tests/study/metrics.h"
#include "tests/study/minimize_from.h"
#include "tests/study/plot.h"
#include "tests/study/samples.h"
#include "tests/study/sections.h"
#include "tests/study/view.h"
#include "tests/support/accuracy.h"
#include "tests/support/random.h"
#include "tests/support/temporary_folder.h"

using namespace rivage::study;
using namespace rivage::test;

TEST_SUITE_BEGIN("study");

namespace {

Regularized ballSurface(double noise) {
    Regularized result = linkedSurface(ballGrid(14, 5.2, Vec3d(0.1, 0.2, -0.1)), {});
    result.normals =
        *estimateNormals({}, result.surface, result.links, {.method = NormalMethod::convolved}, {});
    result.positions.resize(result.surface.pointelCount());
    std::mt19937 random(3);
    for (std::uint32_t i = 0; i < result.positions.size(); ++i) {
        Vec3d& p = result.positions[PointelId{i}];
        p = result.surface.position(PointelId{i});
        for (double& x : p) x += noise * (2 * unitDraw(random) - 1);
    }
    return result;
}

double greatestDifference(const PointelVectors& a, const PointelVectors& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        most = std::max(most, (a.raw()[i] - b.raw()[i]).norm());
    return most;
}

}  // namespace

TEST_CASE("differential: at the lattice minimizeFrom finds the minimum of core") {
    for (const std::optional<double> limit : {std::optional<double>(), std::optional(0.3)}) {
        const Regularized ball = ballSurface(0);
        const EnergyOptions options;
        const Energy energy(ball.surface, ball.normals,
                            EnergyWeights::uniform(ball.surface, options), options, 1);
        SolveOptions solve;
        solve.displacementLimit = limit;
        const PointelVectors expected = minimize(energy, solve, {})->positions;
        CHECK(greatestDifference(minimizeFrom(energy, ball.positions, limit), expected) < 1e-3);
    }
}

// The free minimum is linear in the rest positions, and moved ones must change it.
TEST_CASE("minimizeFrom: the minimum is linear in the rest positions") {
    const Regularized ball = ballSurface(0.4);
    const EnergyOptions options;
    const Energy energy(ball.surface, ball.normals, EnergyWeights::uniform(ball.surface, options),
                        options, 1);
    const PointelVectors lattice = energy.restPositions();
    PointelVectors half = lattice;
    for (std::size_t i = 0; i < half.size(); ++i)
        half.raw()[i] = 0.5 * (lattice.raw()[i] + ball.positions.raw()[i]);
    const PointelVectors a = minimizeFrom(energy, lattice, std::nullopt);
    const PointelVectors b = minimizeFrom(energy, ball.positions, std::nullopt);
    PointelVectors mean = a;
    for (std::size_t i = 0; i < mean.size(); ++i) mean.raw()[i] = 0.5 * (a.raw()[i] + b.raw()[i]);
    CHECK(greatestDifference(a, b) > 0.02);
    CHECK(greatestDifference(minimizeFrom(energy, half, std::nullopt), mean) < 1e-3);
}

TEST_CASE("differential: distances and normals as tests/support measures them") {
    for (const char* name : {"sphere", "sectors", "box"}) {
        CAPTURE(name);
        const Shape shape = digitize(body(name), 24, pose(1));
        Bench bench(shape.grid, {});
        const Outcome outcome = bench.run(method("studio"));
        const Measures m = measure(shape, outcome, {.bothWays = true, .thorough = true});
        const Regularized result = regularize(shape.grid, {});
        const PositionErrors expected = positionErrors(shape, result);
        CHECK(m[Measure::rms] == doctest::Approx(expected.rms));
        CHECK(m[Measure::max] == doctest::Approx(expected.max));
        CHECK(m[Measure::bias] == doctest::Approx(expected.bias));
        CHECK(m[Measure::normalMean] == doctest::Approx(expected.normalMean));
        CHECK(m[Measure::volume] ==
              doctest::Approx(volumeErrorPercent(shape.grid, result)).epsilon(0.02));
        CHECK(m[Measure::wrong] == 0);
        CHECK(m[Measure::crossing] == 0);
        CHECK(m[Measure::hausdorff] >= m[Measure::max]);
    }
}

TEST_CASE("measure: corners turned over, collapsed faces and missing surface are seen") {
    const Shape shape = digitize(body("box"), 20, pose(0));
    Bench bench(shape.grid, {});
    Outcome outcome = bench.run(method("raw"));
    const Measures before = measure(shape, outcome, {.bothWays = true, .thorough = true});
    for (std::size_t f = 0; f < 20; ++f) {
        auto& corners = outcome.mesh.faces[f].corners;
        std::swap(corners[1], corners[3]);
    }
    for (std::size_t f = 20; f < 30; ++f) {
        auto& corners = outcome.mesh.faces[f].corners;
        corners[1] = corners[0];
        corners[2] = corners[3];
    }
    const Measures turned = measure(shape, outcome, {});
    CHECK(turned[Measure::inverted] > before[Measure::inverted]);
    CHECK(turned[Measure::degenerate] > before[Measure::degenerate]);
    outcome.mesh.faces.resize(outcome.mesh.faces.size() / 2);
    CHECK(farthestFrom(outcome.mesh, outcome.mesh.vertices) > 4);
    CHECK(measure(shape, outcome, {.bothWays = true, .thorough = true})[Measure::hausdorff] > 4);
}

TEST_CASE("farthestFrom: known distances to one triangle") {
    const StudyMesh mesh{{Vec3d(0, 0, 0), Vec3d(4, 0, 0), Vec3d(0, 4, 0)},
                         {{{0, 1, 2, 2}, {Label{1}, Label{0}}}}};
    CHECK(farthestFrom(mesh, {Vec3d(1, 1, 2.5)}) == doctest::Approx(2.5));
    CHECK(farthestFrom(mesh, {Vec3d(-3, -4, 0)}) == doctest::Approx(5));
    CHECK(farthestFrom(mesh, {Vec3d(3, 3, 0)}) == doctest::Approx(std::sqrt(2)));
    CHECK(farthestFrom(mesh, {Vec3d(1, 1, 0), Vec3d(0, 0, -1)}) == doctest::Approx(1));
}

TEST_CASE("statistics: intervals, quotients and orders of known data") {
    const Interval interval = meanOf({1, 2, 3, 4});
    CHECK(interval.mean == doctest::Approx(2.5));
    CHECK(interval.half == doctest::Approx(3.182 * std::sqrt(5.0 / 3 / 4)));
    CHECK(studentQuantile(7) == doctest::Approx(2.365));
    CHECK(studentQuantile(60) == doctest::Approx(2.000).epsilon(0.001));
    CHECK(std::isnan(meanOf({1}).half));
    const Ratio ratio = ratioOf({{1, 2}, {2, 4}, {3, 6}});
    CHECK(ratio.value == doctest::Approx(0.5));
    CHECK(ratio.less());
    CHECK_FALSE(ratioOf({{1, 2}, {2, 1}}).less());
    std::vector<std::pair<double, double>> points;
    for (const double h : {0.1, 0.05, 0.025, 0.0125}) points.emplace_back(h, 3 * std::pow(h, 1.5));
    CHECK(orderOf(points).mean == doctest::Approx(1.5));
    CHECK(orderOf(points).half < 1e-6);
}

TEST_CASE("samples: what was written is read back") {
    const TemporaryFolder folder;
    Samples samples(2);
    samples[0] = {"cube and ball", 32, 3, "paper, auto normals", 0.25, {}, 12.5};
    samples[0].measures[Measure::rms] = 0.125;
    samples[1] = {"sphere", 16, 0, "MC", 0, {}, 1};
    REQUIRE(writeSamples(folder.path(), "shapes", samples));
    const auto read = readSamples(folder.path(), "shapes");
    REQUIRE(read);
    REQUIRE(read->size() == 2);
    CHECK(read->at(0).method == "paper, auto normals");
    CHECK(read->at(0).level == 0.25);
    CHECK(read->at(0).measures[Measure::rms] == 0.125);
    CHECK(std::isnan(read->at(0).measures[Measure::max]));
    CHECK(read->at(0).milliseconds == 12.5);
    CHECK_FALSE(readSamples(folder.path(), "creases"));
}

TEST_CASE("view: quotients pair the same shapes and poses") {
    Samples samples;
    for (int pose = 0; pose < 3; ++pose)
        for (const char* shape : {"a", "b"}) {
            // Four times as large on one shape, half as large on the other.
            const double factor = shape[0] == 'a' ? 4 : 0.5;
            Sample sample{shape, 16, pose, "theirs", 0, {}, 1};
            sample.measures[Measure::rms] = pose + 1;
            samples.push_back(sample);
            sample.method = "ours";
            sample.measures[Measure::rms] *= factor;
            samples.push_back(sample);
        }
    const View view(samples);
    CHECK(view.ratio({.method = "ours"}, "theirs").value == doctest::Approx(std::sqrt(2)));
    CHECK(view.worseShapes({.method = "ours"}, "theirs") == std::vector<std::string>{"a"});
    CHECK(view.mean({.shape = "b", .method = "ours"}).mean == doctest::Approx(1));
    CHECK(view.mean({.method = "ours"}).mean == doctest::Approx(4.5));
}

TEST_CASE("determinism: threads do not change the samples") {
    const TemporaryFolder folder;
    Effort scale{.poses = 1, .resolution = 12, .largest = 16, .threads = 1, .quick = true};
    REQUIRE(writeSamples(folder.path(), "one", runSection("position-noise", scale)));
    scale.threads = 7;
    REQUIRE(writeSamples(folder.path(), "seven", runSection("position-noise", scale)));
    CHECK(readFile(folder.path() + "/one.csv") == readFile(folder.path() + "/seven.csv"));
}

TEST_CASE("plot: lines, error bars, logarithms; values that do not fit are left out") {
    const double none = std::numeric_limits<double>::quiet_NaN();
    const PlotPanel panel{
        "a < b", "x",  "y",
        false,   true, {{"studio", {{0, 0.1, 0.01}, {1, 0, 0}, {2, none, 0}, {3, 1, none}}}}};
    const std::string svg = drawPlot({panel}, 1);
    CHECK(svg.find("nan") == std::string::npos);
    CHECK(svg.find("inf") == std::string::npos);
    CHECK(svg.find("a &lt; b") != std::string::npos);
    std::size_t dots = 0;
    for (std::size_t at = svg.find("<circle"); at != std::string::npos;
         at = svg.find("<circle", at + 1))
        ++dots;
    CHECK(dots == 3);  // one of them in the legend
}

TEST_SUITE_END();
