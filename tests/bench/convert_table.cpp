#include <array>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "core/formats/read_scene.h"
#include "core/pipeline.h"
#include "core/samples/samples.h"
#include "tests/bench/inputs.h"
#include "tests/support/intersections.h"
#include "tests/support/regularized.h"
#include "tests/support/voxel_centres.h"

// convert_table [FILE...]: converts each grid file, or without files each sample scene, with the
// default options on one thread and prints a Markdown table: size, milliseconds by stage, bytes,
// and the guarantees as they were checked. Crossing faces and wrong centres are counted by code
// that the conversion does not use; crossing are pairs of faces that intersect without a common
// vertex.

using namespace rivage::core;
using namespace rivage::test;

namespace {

/// Wall time by stage, from the stages that a conversion reports.
class StageClock {
public:
    void enter(Stage stage) {
        const auto now = Clock::now();
        if (running_) milliseconds[static_cast<std::size_t>(stage_)] += since(now);
        stage_ = stage;
        started_ = now;
        running_ = true;
    }
    void stop() {
        milliseconds[static_cast<std::size_t>(stage_)] += since(Clock::now());
        running_ = false;
    }
    std::array<double, kStageCount> milliseconds{};

private:
    using Clock = std::chrono::steady_clock;
    [[nodiscard]] double since(Clock::time_point now) const {
        return std::chrono::duration<double, std::milli>(now - started_).count();
    }
    Clock::time_point started_;
    Stage stage_ = Stage::parse;
    bool running_ = false;
};

struct Faults {
    std::size_t wrongCentres = 0;
    std::size_t crossing = 0;
};

Faults countFaults(const Input& input) {
    const VoxelGrid grid =
        *mergeScene(*readScene(input.bytes, input.options, {}), input.options, {});
    const Regularized result = regularize(grid, {});
    return {countWrongCentres(grid, result.surface, result.positions),
            countIntersections(result.surface, result.positions)};
}

bool printRow(const Input& input) {
    StageClock clock;
    const RunContext run{.progress = [&](Stage stage, double) { clock.enter(stage); }};
    const auto artifact = convert(input.bytes, {.input = input.options}, {}, run);
    clock.stop();
    if (!artifact) {
        std::printf("| %s | %s |\n", input.name.c_str(), artifact.error().message.c_str());
        return false;
    }
    const ConversionReport& report = artifact->report;
    std::size_t open = 0;
    for (const bool closed : report.output.closed) open += !closed;
    const Faults faults = countFaults(input);
    double total = 0;
    std::printf("| %s | %zu | %zu |", input.name.c_str(),
                static_cast<std::size_t>(report.input.voxels),
                static_cast<std::size_t>(report.surface.surfels));
    for (const double ms : clock.milliseconds) {
        std::printf(" %.1f |", ms);
        total += ms;
    }
    std::printf(" %.0f | %d | %zu | %zu -> %zu | %zu | %zu | %zu |\n", total,
                report.solve.iterations, artifact->bytes.size(),
                static_cast<std::size_t>(report.solve.invertedBefore),
                static_cast<std::size_t>(report.solve.invertedAfter), open, faults.wrongCentres,
                faults.crossing);
    std::fflush(stdout);
    return open == 0 && faults.wrongCentres == 0 && faults.crossing == 0 &&
           report.solve.invertedAfter == 0;
}

}  // namespace

int main(int argc, char** argv) {
    std::printf("| file | voxels | surfels |");
    for (std::size_t s = 0; s < kStageCount; ++s)
        std::printf(" %s ms |", stageName(static_cast<Stage>(s)));
    std::printf(
        " total ms | iterations | bytes | inverted | open labels | wrong centres | crossing |\n");
    std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    bool good = true;
    for (const Input& input : inputs(argc - 1, argv + 1)) good = printRow(input) && good;
    return good ? 0 : 1;
}
