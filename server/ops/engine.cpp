#include "server/ops/engine.h"

#include <fstream>
#include <iterator>
#include <utility>

#include "core/pipeline.h"
#include "server/jobs/digest.h"

namespace rivage::server {
namespace {

core::Result<core::Artifact> inspectAsJson(std::span<const std::byte> input,
                                           const core::ConversionOptions& options,
                                           const proto::Json&, const core::RunContext& run) {
    auto inspection = core::inspect(input, options.input, run);
    if (!inspection) return core::fail(std::move(inspection.error()));
    const std::string text = proto::writeJson(core::toJson(*inspection)) + "\n";
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    core::Artifact artifact{{bytes, bytes + text.size()}, "application/json", "json", {}};
    artifact.report.input = std::move(inspection->input);
    artifact.report.surface.surfels = inspection->surfels;
    return artifact;
}

/// Differs between builds, since another build may give other bytes: the version with a digest of
/// the program.
std::string engineVersion() {
    std::ifstream file("/proc/self/exe", std::ios::binary);
    const std::string program{std::istreambuf_iterator<char>(file), {}};
    return std::string(RIVAGE_VERSION) + "+" +
           sha256(std::as_bytes(std::span(program))).hex.substr(0, 16);
}

}  // namespace

Engine coreEngine() { return {core::convert, inspectAsJson, engineVersion()}; }

Samples coreSamples() { return {core::sampleNames(), core::sampleScene}; }

}  // namespace rivage::server
