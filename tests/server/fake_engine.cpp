#include "tests/server/fake_engine.h"

#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace rivage::test {
namespace {

using core::Error;
using core::ErrorCode;
using core::fail;
using namespace std::chrono_literals;

core::Result<core::Artifact> artifactOf(const std::string& bytes, const std::string& text) {
    const auto* data = reinterpret_cast<const std::byte*>(bytes.data());
    core::Artifact result{{data, data + bytes.size()}, "model/gltf-binary", "glb", {}};
    result.report.input.voxels = text.size();
    return result;
}

core::Result<core::Artifact> artifact(const std::string& text) {
    return artifactOf("asset of " + text, text);
}

/// The number behind the colon of "hold:250 more".
std::uint64_t numberIn(const std::string& text) {
    std::uint64_t number = 0;
    std::from_chars(text.data() + text.find(':') + 1, text.data() + text.size(), number);
    return number;
}

core::Result<core::Artifact> big(const std::string& text) {
    std::string bytes(numberIn(text), '\0');
    std::uint32_t state = 1;  // a linear congruential generator: nothing that compresses
    for (char& byte : bytes) byte = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
    return artifactOf(bytes, text);
}

core::Result<core::Artifact> hold(const std::string& text, const core::RunContext& run) {
    const auto start = std::chrono::steady_clock::now();
    const auto length = std::chrono::milliseconds(numberIn(text));
    while (std::chrono::steady_clock::now() - start < length) {
        if (run.stopped()) return fail(run.stopError());
        std::this_thread::sleep_for(1ms);
    }
    return artifact(text);
}

core::Result<core::Artifact> wait(Gate& gate, const std::string& text,
                                  const core::RunContext& run) {
    if (text.starts_with("stuck")) std::this_thread::sleep_for(200ms);
    while (!gate.open) {
        if (run.stopped()) return fail(run.stopError());
        run.report(core::Stage::solve, 0.5);
        std::this_thread::sleep_for(1ms);
    }
    return artifact(text);
}

/// What a defect in the engine may do to the process.
void misbehave(const std::string& text) {
    if (text.starts_with("crash")) std::raise(SIGSEGV);
    if (text.starts_with("abort")) std::abort();
    while (text.starts_with("loop")) std::this_thread::sleep_for(1s);
    std::vector<std::vector<char>> hoard;
    while (text.starts_with("oom")) hoard.emplace_back(16 << 20, '\1');
}

core::Result<core::Artifact> convert(Gate& gate, const std::string& text,
                                     const core::RunContext& run) {
    for (const core::Stage stage : {core::Stage::parse, core::Stage::surface}) run.report(stage, 0);
    misbehave(text);
    if (text.starts_with("slow") || text.starts_with("stuck")) return wait(gate, text, run);
    if (text.starts_with("hold:")) return hold(text, run);
    if (text.starts_with("big:")) return big(text);
    if (text == "empty") return fail(ErrorCode::emptyGrid, "the grid has no voxel", "/grid");
    if (text == "bad") return fail(ErrorCode::malformedInput, "it is not a grid", "/grid");
    if (text == "odd") return fail(ErrorCode::unsupportedFormat, "which format?", "/grid");
    if (text == "big") return fail(Error{ErrorCode::tooLarge, "voxels", "/grid", 5, 6, "--max"});
    if (text == "throw") throw std::runtime_error("secret");
    if (text == "memory") throw std::bad_alloc();
    return artifact(text);
}

}  // namespace

server::Engine fakeEngine(Gate& gate) {
    const auto run = [&gate](std::span<const std::byte> input, const core::ConversionOptions&,
                             const proto::Json&, const core::RunContext& context) {
        ++gate.started;
        ++gate.running;
        struct Leave {
            Gate& gate;
            ~Leave() { --gate.running; }
        } leave{gate};
        const std::string text(reinterpret_cast<const char*>(input.data()), input.size());
        return convert(gate, text, context);
    };
    const auto inspect = [run](std::span<const std::byte> input,
                               const core::ConversionOptions& options, const proto::Json& echo,
                               const core::RunContext& context) {
        auto result = run(input, options, echo, context);
        if (result) result->mediaType = "application/json";
        return result;
    };
    return {run, inspect};
}

server::Samples fakeSamples() {
    return {
        {"dot"}, [](const std::string&) {
            return core::Result<std::vector<std::byte>>(std::vector<std::byte>(3, std::byte{'v'}));
        }};
}

}  // namespace rivage::test
