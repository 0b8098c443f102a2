#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/formats/read_scene.h"
#include "core/pipeline.h"
#include "tests/support/regularized.h"
#include "tests/support/voxel_centres.h"

// convert_table FILE...: converts each grid file with the default options on one thread and prints
// a Markdown table: size, milliseconds by stage, bytes, and the guarantees as they were checked.

using namespace rivage::core;
using namespace rivage::test;

namespace {

std::vector<std::byte> readFile(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    std::vector<std::byte> bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

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

std::size_t wrongCentres(const std::vector<std::byte>& bytes) {
    const VoxelGrid grid = *mergeScene(*readScene(bytes, {}, {}), {}, {});
    const Regularized result = regularize(grid, {});
    return countWrongCentres(grid, result.surface, result.positions);
}

bool printRow(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = readFile(path);
    StageClock clock;
    const RunContext run{.progress = [&](Stage stage, double) { clock.enter(stage); }};
    const auto artifact = convert(bytes, {}, {}, run);
    clock.stop();
    const std::string name = path.stem().string();
    if (!artifact) {
        std::printf("| %s | %s |\n", name.c_str(), artifact.error().message.c_str());
        return false;
    }
    const ConversionReport& report = artifact->report;
    std::size_t open = 0;
    for (const bool closed : report.output.closed) open += !closed;
    const std::size_t wrong = wrongCentres(bytes);
    double total = 0;
    std::printf("| %s | %zu | %zu |", name.c_str(), static_cast<std::size_t>(report.input.voxels),
                static_cast<std::size_t>(report.surface.surfels));
    for (const double ms : clock.milliseconds) {
        std::printf(" %.1f |", ms);
        total += ms;
    }
    std::printf(" %.0f | %d | %zu | %zu -> %zu | %zu | %zu |\n", total, report.solve.iterations,
                artifact->bytes.size(), static_cast<std::size_t>(report.solve.invertedBefore),
                static_cast<std::size_t>(report.solve.invertedAfter), open, wrong);
    return open == 0 && wrong == 0 && report.solve.invertedAfter == 0;
}

}  // namespace

int main(int argc, char** argv) {
    std::printf("| file | voxels | surfels |");
    for (std::size_t s = 0; s < kStageCount; ++s)
        std::printf(" %s ms |", stageName(static_cast<Stage>(s)));
    std::printf(" total ms | iterations | bytes | inverted | open labels | wrong centres |\n");
    std::printf("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    bool good = argc > 1;
    for (int i = 1; i < argc; ++i) good = printRow(argv[i]) && good;
    return good ? 0 : 1;
}
