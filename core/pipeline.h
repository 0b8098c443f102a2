#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/base/report.h"
#include "core/base/result.h"
#include "core/base/run_context.h"

namespace rivage::core {

/// The bytes that a conversion returns, with what there is to say about them.
struct Artifact {
    std::vector<std::byte> bytes;
    std::string mediaType;  ///< "model/gltf-binary", "model/obj", ...
    std::string extension;  ///< "glb", "obj", "vox", "nrrd"
    ConversionReport report;
};

/// The whole conversion: bytes of a grid in, bytes of an asset out.
///
/// Scene -> VoxelGrid -> DigitalSurface -> normals -> positions -> Mesh -> artifact, or
/// ... -> positions -> VoxelGrid at another resolution -> artifact.
/// @param optionsEcho  the options as the caller knows them, put into the report
/// @return  the same bytes for the same input and options, for any number of threads
/// @errors  every code of the stages; cancelled or timedOut if `run` asks to stop
/// @cost    linear in stored voxels and surfels but for the solver's iterations
Result<Artifact> convert(std::span<const std::byte> input, const ConversionOptions& options,
                         const nlohmann::ordered_json& optionsEcho, const RunContext& run);

/// Reads and merges only. Answers with the errors that `convert` would give before its solver.
Result<Inspection> inspect(std::span<const std::byte> input, const InputOptions& options,
                           const RunContext& run);

/// Names of the sample scenes that `sampleScene` knows.
[[nodiscard]] std::vector<std::string> sampleNames();

/// A sample scene as the bytes of a .vox file.
/// @errors notFound if no sample has this name
Result<std::vector<std::byte>> sampleScene(const std::string& name);

}  // namespace rivage::core
