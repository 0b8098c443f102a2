#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

#include "core/grid/scene.h"
#include "core/normals/normal_field.h"
#include "core/samples/samples.h"
#include "core/solve/minimize.h"
#include "tests/support/balls.h"

// solve_table [REPEATS [SCENE...]]: solves island, balls128 and balls256 (or the scenes named:
// island or ballsN) with the weights of both presets and prints a Markdown table. Milliseconds are
// the best of REPEATS (3), of one thread, with all set-up of the energy and the solver but without
// the normals. The error is the largest coordinate difference to the minimizer at 1e-12.

using namespace rivage::core;
using namespace rivage::test;

namespace {

VoxelGrid makeScene(const std::string& name) {
    if (name.rfind("balls", 0) == 0) return ballsGrid(std::atoi(name.c_str() + 5));
    InputOptions options;
    for (const SampleInfo& info : sampleInfos())
        if (info.name == name) options.labels = info.labels;
    return *mergeScene(*makeSample(name), options, {});
}

struct Problem {
    const DigitalSurface& surface;
    const NormalField& normals;
    MethodOptions options;

    [[nodiscard]] Energy energy() const {
        return {surface, normals, EnergyWeights::uniform(surface, options.energy), options.energy,
                1};
    }
};

struct Run {
    Solution solution;
    double milliseconds = std::numeric_limits<double>::infinity();
};

Run bestOf(int repeats, const Problem& problem, const SolveOptions& options) {
    Run run;
    for (int i = 0; i < repeats; ++i) {
        NormalField normals = problem.normals;
        const auto start = std::chrono::steady_clock::now();
        const Energy energy(problem.surface, std::move(normals),
                            EnergyWeights::uniform(problem.surface, problem.options.energy),
                            problem.options.energy, 1);
        run.solution = *minimize(energy, options, {});
        const std::chrono::duration<double, std::milli> time =
            std::chrono::steady_clock::now() - start;
        run.milliseconds = std::min(run.milliseconds, time.count());
    }
    return run;
}

double errorOf(const PointelVectors& a, const PointelVectors& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, (a.raw()[i] - b.raw()[i]).cwiseAbs().maxCoeff());
    return largest;
}

/// The fewest iterations that come within 0.02 voxel, to the accuracy that bisection has where the
/// error does not fall in every step; the number found does reach it.
int iterationsToVisible(const Energy& energy, SolveOptions options, const PointelVectors& exact,
                        int most) {
    constexpr double kVisible = 0.02;  // voxels
    int fewest = 1;
    while (fewest < most) {
        options.maxIterations = (fewest + most) / 2;
        const auto solution = minimize(energy, options, {});
        if (errorOf(solution->positions, exact) <= kVisible)
            most = options.maxIterations;
        else
            fewest = options.maxIterations + 1;
    }
    return most;
}

void printRow(const std::string& scene, const char* preset, const Problem& problem, int repeats) {
    const Energy energy = problem.energy();
    SolveOptions options = problem.options.solve;
    options.tolerance = 1e-12;
    options.maxIterations = 20000;
    const PointelVectors exact = minimize(energy, options, {})->positions;

    options = problem.options.solve;
    const Run whole = bestOf(repeats, problem, options);
    options.maxIterations = iterationsToVisible(energy, options, exact, whole.solution.iterations);
    const Run visible = bestOf(repeats, problem, options);
    std::printf("| %s %s | %s | %zu | %d | %.1f | %d | %.1f | %.2g |\n", scene.c_str(), preset,
                whole.solution.solver.c_str(), energy.size(), whole.solution.iterations,
                whole.milliseconds, visible.solution.iterations, visible.milliseconds,
                whole.solution.residual);
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    const int repeats = argc > 1 ? std::max(1, std::atoi(argv[1])) : 3;
    std::vector<std::string> scenes(argv + std::min(argc, 2), argv + argc);
    if (scenes.empty()) scenes = {"island", "balls128", "balls256"};
    std::printf(
        "| problem | solver | pointels | iterations | ms | iterations to 0.02 | ms to 0.02 | "
        "KKT residual |\n|---|---|---|---|---|---|---|---|\n");
    for (const std::string& scene : scenes) {
        const VoxelGrid grid = makeScene(scene);
        const DigitalSurface surface = *extractSurface(grid, {});
        const SurfelLinks links = *linkSurfels(surface, {});
        for (const auto& [name, preset] :
             {std::pair{"paper", Preset::paper}, std::pair{"studio", Preset::studio}}) {
            const MethodOptions options = presetOptions(preset);
            const NormalField normals = *estimateNormals(grid, surface, links, options.normals, {});
            printRow(scene, name, {surface, normals, options}, repeats);
        }
    }
    return 0;
}
