#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/base/run_context.h"

namespace rivage::core {

/// Whether bytes begin like a gzip stream.
[[nodiscard]] bool isGzip(std::span<const std::byte> bytes);

/// Unpacks a zlib stream, or gzip streams one after the other, as far as `most` bytes. Who expects n
/// bytes asks for n + 1: then the checksum behind them is looked at, and what is too much is seen.
/// @errors malformedInput if the stream is damaged or breaks off; cancelled
/// @cost   up to three times what comes out, for a moment
Result<std::vector<std::byte>> inflateUpTo(std::span<const std::byte> packed, std::uint64_t most,
                                           const RunContext& run);

}  // namespace rivage::core
