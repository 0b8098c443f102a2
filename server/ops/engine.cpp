#include "server/ops/engine.h"

#include <utility>

#include "core/pipeline.h"

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

}  // namespace

Engine coreEngine() { return {core::convert, inspectAsJson}; }

Samples coreSamples() { return {core::sampleNames(), core::sampleScene}; }

}  // namespace rivage::server
