#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "client/failure.h"
#include "proto/json.h"

namespace rivage::client {

/// How two conversions are compared.
struct CompareSettings {
    std::string nameA = "A";  ///< for the table and for failures
    std::string nameB = "B";
    std::size_t samples = 50'000;       ///< points on each surface, beside all vertices
    std::optional<double> voxelSize;    ///< metres; else what the reports in the files say
    std::optional<double> maxDistance;  ///< voxels: the comparison says whether it is exceeded
    unsigned threads = 0;               ///< 0: as many as the machine has; never changes the answer
};

/// Two conversions (GLB with Draco or without, OBJ) side by side: bytes, counts, boxes, area,
/// volume, the distances between the surfaces in both directions, normals, colours, and what the
/// reports in the files say of energy and options. README.md has the members of the answer.
/// @errors  refused if a file is malformed, has no surface or is beyond what is read here; usage if
///          `maxDistance` is given but nothing tells how long a voxel is
/// @cost    O((samples + vertices) log triangles) time, about 200 bytes a triangle
[[nodiscard]] Outcome<proto::Json> compareAssets(const std::string& bytesA,
                                                 const std::string& bytesB,
                                                 const CompareSettings& settings = {});

/// A comparison as lines for a person; the last one is the verdict.
[[nodiscard]] std::string comparisonTable(const proto::Json& comparison);

/// How a run ends that made this comparison: `failed` if `maxDistance` was exceeded, else `ok`.
[[nodiscard]] ExitCode exitOf(const proto::Json& comparison);

}  // namespace rivage::client
