#include <algorithm>
#include <cmath>

#include "core/samples/samples.h"
#include "tests/study/sections.h"
#include "tests/study/thread_clock.h"

namespace rivage::study {
namespace {

Sample sampleOf(const test::Regularized& input, const std::string& name, double level) {
    Sample sample{.shape = "island", .resolution = 64, .method = name, .level = level};
    sample.measures[Measure::faces] = static_cast<double>(input.surface.surfelCount());
    return sample;
}

/// Angle between the faces of two sets of positions, degrees, weighted by the area of the second.
double normalDifference(const DigitalSurface& surface, const PointelVectors& x,
                        const PointelVectors& goal) {
    double sum = 0;
    double areas = 0;
    for (const auto& c : surface.corners) {
        const Vec3d a = (x[c[2]] - x[c[0]]).cross(x[c[3]] - x[c[1]]);
        const Vec3d b = (goal[c[2]] - goal[c[0]]).cross(goal[c[3]] - goal[c[1]]);
        sum += b.norm() * std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
        areas += b.norm();
    }
    return sum / areas;
}

double rmsDifference(const PointelVectors& x, const PointelVectors& goal) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += (x.raw()[i] - goal.raw()[i]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(x.size()));
}

/// Milliseconds of one gradient of the energy, the median of several.
Sample gradientSample(const Energy& energy, const test::Regularized& input) {
    constexpr int kRepeats = 21;
    Sample sample = sampleOf(input, "one gradient", 1);
    const PointelVectors rest = energy.restPositions();
    std::vector<double> times;
    for (int i = 0; i < kRepeats; ++i) {
        const ThreadClock clock;
        const PointelVectors gradient = energy.gradient(rest);
        times.push_back(clock.milliseconds());
        sample.measures[Measure::rms] = gradient.raw().front().norm();
    }
    std::nth_element(times.begin(), times.begin() + kRepeats / 2, times.end());
    sample.milliseconds = times[kRepeats / 2];
    return sample;
}

void addSteps(const Energy& energy, const test::Regularized& input, const SolveOptions& options,
              const std::string& name, Samples& samples) {
    const PointelVectors goal = minimize(energy, options, {})->positions;
    for (const int steps : {0, 1, 2, 5, 10, 20, 50, 100}) {
        SolveOptions limited = options;
        limited.solver =
            name == "accelerated" ? SolverKind::accelerated : SolverKind::gradientDescent;
        limited.maxIterations = steps;
        const ThreadClock clock;
        const PointelVectors x =
            steps == 0 ? energy.restPositions() : minimize(energy, limited, {})->positions;
        Sample sample = sampleOf(input, name, steps);
        sample.milliseconds = clock.milliseconds();
        sample.measures[Measure::normalMean] = normalDifference(input.surface, x, goal);
        sample.measures[Measure::rms] = rmsDifference(x, goal);
        samples.push_back(sample);
    }
}

}  // namespace

Samples runSpeed() {
    const Scene scene = *makeSample("island");
    const VoxelGrid grid = *mergeScene(scene, {}, {});
    const MethodOptions options;
    test::Regularized input = test::linkedSurface(grid, options);
    input.normals = *estimateNormals(grid, input.surface, input.links, options.normals, {});
    const Energy energy(input.surface, input.normals,
                        EnergyWeights::uniform(input.surface, options.energy), options.energy, 1);
    Samples samples = {gradientSample(energy, input)};
    addSteps(energy, input, options.solve, "gradient descent", samples);
    addSteps(energy, input, options.solve, "accelerated", samples);
    return samples;
}

}  // namespace rivage::study
