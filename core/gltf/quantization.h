#pragma once

#include <array>

#include "core/base/options.h"
#include "core/base/run_context.h"
#include "core/gltf/placement.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// The grid that positions of a whole scene are rounded to. One grid for all parts: positions that
/// are equal before encoding are equal after decoding.
struct Quantization {
    std::array<float, 3> origin{};  ///< output coordinates, metres
    float range = 1;                ///< metres, the same along the three axes
    int bits = 14;
    [[nodiscard]] double step() const { return range / ((1U << bits) - 1.0); }
};

/// The grid for a mesh. Automatic bits give steps of 1/128 voxel that hit every lattice point, so
/// flat walls stay flat; where 20 bits do not reach for that, and with given bits, the range is
/// the extent of the mesh.
/// @param mesh  not empty, positions finite
/// @source      ours: a step of at most 0.01 voxel cannot be seen
[[nodiscard]] Quantization quantizationOf(const Mesh& mesh, const Placement& placement,
                                          const OutputOptions& options, const RunContext& run = {});

}  // namespace rivage::core
