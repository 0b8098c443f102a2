#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/run_context.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// Ascending indices of quads of one primitive.
using Chunk = std::vector<std::uint32_t>;

/// Cuts a primitive into chunks of at most so many quads, across its longest side again and again,
/// so that the seams between chunks are short.
/// @param most  at least 1
/// @return  one chunk for a primitive that is small enough; each quad is in one chunk. Means
///          nothing once `run` asked to stop.
/// @cost    O(quads log chunks)
[[nodiscard]] std::vector<Chunk> cutQuads(const MeshPrimitive& primitive, std::size_t most,
                                          const RunContext& run);

/// The quads of a chunk as a primitive of their own; vertices and points keep their order.
[[nodiscard]] MeshPrimitive chunkOf(const MeshPrimitive& primitive,
                                    std::span<const std::uint32_t> quads);

}  // namespace rivage::core
