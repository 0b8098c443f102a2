#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/formats/write_vox.h"
#include "core/pipeline.h"
#include "tests/support/balls.h"

// stop_table [STOPS [CASE...]]: how long a conversion goes on after it was asked to stop. Each case
// runs once to its end, then STOPS (20) times to a moment spread over that run and, where the first
// run was not polled for longest, right behind the last poll before. Prints milliseconds from the
// request to the return, destruction of everything included: the worst by stage. Exits 1 if one is
// above 250 ms.

using namespace rivage::core;
using namespace rivage::test;

namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;
using ByStage = std::array<double, kStageCount>;

constexpr double kLimit = 250;

struct Case {
    std::string name;
    std::vector<std::byte> bytes;
    ConversionOptions options;
    int threads = 1;
};

std::vector<std::byte> rawOf(const VoxelGrid& grid) {
    const Vec3i& size = grid.voxels.size();
    std::vector<std::byte> raw(static_cast<std::size_t>(size.x()) * size.y() * size.z());
    grid.voxels.forEach([&](const Vec3i& at, MaterialId material) {
        raw[(static_cast<std::size_t>(at.z()) * size.y() + at.y()) * size.x() + at.x()] =
            static_cast<std::byte>(index(material));
    });
    return raw;
}

/// Every voxel is one of two materials or empty, whatever its neighbours are.
std::vector<std::byte> noise(int side) {
    std::vector<std::byte> raw(static_cast<std::size_t>(side) * side * side);
    std::uint64_t state = 1;
    for (std::byte& value : raw) {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        value = static_cast<std::byte>(state >> 62 > 1 ? 0 : 1 + (state >> 62));
    }
    return raw;
}

std::vector<std::byte> voxOf(const VoxelGrid& grid) {
    Scene scene;
    scene.models.push_back(grid.voxels);
    scene.instances.push_back({.frames = {0}});
    scene.materials = IdVector<MaterialId, Material>(grid.materials.size());
    return *writeVox(scene);
}

ConversionOptions raw(int side, Preset preset) {
    ConversionOptions options{.preset = preset, .method = presetOptions(preset)};
    options.input.format = GridFormat::raw;
    options.input.dims = Vec3i::Constant(side);
    options.output.parts = Parts::interfaces;
    return options;
}

Case ballsCase(const std::string& name, int side, Preset preset, int threads = 1) {
    return {name, rawOf(ballsGrid(side)), raw(side, preset), threads};
}

/// Trivial normals, as the others would need minutes, and few steps of the solver.
Case noiseCase(const std::string& name, Compression compression, OutputFormat format,
               int threads = 1) {
    constexpr int kSide = 128;
    ConversionOptions options = raw(kSide, Preset::studio);
    options.method.normals.method = NormalMethod::trivial;
    options.method.solve.maxIterations = 20;
    options.output.compression = compression;
    options.output.format = format;
    options.output.colors = Colors::label;
    return {name, noise(kSide), options, threads};
}

std::vector<Case> allCases() {
    constexpr int kSide = 256;
    std::vector<Case> cases{ballsCase("studio", kSide, Preset::studio),
                            ballsCase("studio-2-threads", kSide, Preset::studio, 2),
                            ballsCase("paper", kSide, Preset::paper),
                            ballsCase("organic", kSide, Preset::organic),
                            ballsCase("noisy", kSide, Preset::noisy)};
    Case vox{"vox", voxOf(ballsGrid(kSide)), cases[0].options};
    vox.options.input = {.labels = LabelMode::palette};
    vox.options.output.parts = Parts::exterior;
    cases.push_back(vox);
    Case features = ballsCase("piecewise-smooth", kSide, Preset::studio);
    features.options.method.normals.method = NormalMethod::piecewiseSmooth;
    cases.push_back(features);
    Case cholesky = ballsCase("cholesky", 80, Preset::paper);
    cholesky.options.method.solve.solver = SolverKind::cholesky;
    cases.push_back(cholesky);
    Case rough{"noise-studio", noise(40), raw(40, Preset::studio)};
    cases.push_back(rough);
    cases.push_back(noiseCase("noise-draco", Compression::draco, OutputFormat::glb));
    cases.push_back(noiseCase("noise-plain", Compression::none, OutputFormat::glb));
    cases.push_back(noiseCase("noise-plain-2-threads", Compression::none, OutputFormat::glb, 2));
    cases.push_back(noiseCase("noise-obj", Compression::none, OutputFormat::obj));
    return cases;
}

/// One conversion that is asked to stop at a moment, or never.
class Trial {
public:
    explicit Trial(double stopAt = 1e300) : stopAt_(stopAt) {}

    /// @return milliseconds it took
    double run(const Case& one) {
        RunContext context{.threads = one.threads};
        context.limits.maxMemory = std::uint64_t{32} << 30;
        context.stopRequested = [this] { return poll(); };
        context.progress = [this](Stage stage, double) {
            if (now() < stopAt_) askedIn_ = stage;
        };
        alone_ = one.threads == 1;
        begin_ = Clock::now();
        {
            const auto artifact = convert(one.bytes, one.options, {}, context);
            if (stopAt_ > 1e299 && !artifact) {
                std::fprintf(stderr, "%s\n", artifact.error().message.c_str());
                std::exit(1);
            }
        }
        return now();
    }
    /// The stage that ran when it was asked, and none if it ended before.
    [[nodiscard]] bool asked() const { return asked_; }
    [[nodiscard]] Stage askedIn() const { return askedIn_; }
    /// Where polls were rarest: the moments before which nothing was asked for longest.
    [[nodiscard]] std::vector<double> quietMoments(std::size_t most) {
        std::sort(gaps_.begin(), gaps_.end(), [](auto& a, auto& b) { return a.first > b.first; });
        std::vector<double> moments;
        for (std::size_t i = 0; i < std::min(most, gaps_.size()); ++i)
            moments.push_back(gaps_[i].second);
        return moments;
    }

private:
    [[nodiscard]] double now() const { return Milliseconds(Clock::now() - begin_).count(); }
    bool poll() {
        const double at = now();
        const double last = last_.exchange(at);
        constexpr double kGap = 10;
        if (alone_ && at - last > kGap && stopAt_ > 1e299) gaps_.push_back({at - last, last});
        // The request comes at `stopAt_`, whenever the next poll is.
        if (at >= stopAt_) asked_ = true;
        return asked_;
    }

    double stopAt_;
    bool alone_ = true;  // one thread, so that gaps between polls mean something
    Clock::time_point begin_;
    std::atomic<double> last_{0};
    std::atomic<Stage> askedIn_{Stage::parse};
    std::atomic<bool> asked_{false};
    std::vector<std::pair<double, double>> gaps_;
};

ByStage worstOf(const Case& one, int stops) {
    Trial whole;
    const double total = whole.run(one);
    std::vector<double> moments =
        one.threads == 1 ? whole.quietMoments(stops / 2) : std::vector<double>{};
    for (int i = 0; i < stops; ++i) moments.push_back(total * (i + 0.5) / stops);
    ByStage worst{};
    for (const double moment : moments) {
        Trial trial(moment);
        const double end = trial.run(one);
        if (!trial.asked()) continue;
        double& most = worst[static_cast<std::size_t>(trial.askedIn())];
        most = std::max(most, end - moment);
    }
    std::printf("| %s | %.1f |", one.name.c_str(), total / 1000);
    for (const double ms : worst) std::printf(" %.0f |", ms);
    std::printf("\n");
    std::fflush(stdout);
    return worst;
}

}  // namespace

int main(int argc, char** argv) {
    const int stops = argc > 1 ? std::atoi(argv[1]) : 20;
    std::printf("| case | run s |");
    for (std::size_t s = 0; s < kStageCount; ++s)
        std::printf(" %s ms |", stageName(static_cast<Stage>(s)));
    std::printf("\n|---|---|---|---|---|---|---|---|\n");
    bool good = true;
    for (const Case& one : allCases()) {
        const bool named = std::any_of(argv + std::min(argc, 2), argv + argc,
                                       [&](const char* name) { return one.name == name; });
        if (argc > 2 && !named) continue;
        for (const double ms : worstOf(one, stops)) good = good && ms <= kLimit;
    }
    return good ? 0 : 1;
}
