#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <span>

#include "core/base/result.h"
#include "core/base/run_context.h"

/// What the fuzz targets share. A target never fails by a return value: it stops the process.
namespace rivage::fuzz {

/// Small enough that a run takes milliseconds, large enough that real code is reached.
inline core::RunContext smallRun() {
    return {.limits = {.maxInputBytes = 1 << 20,
                       .maxVoxels = 1 << 16,
                       .maxExtent = 1024,
                       .maxMaterials = 1000,
                       .maxLabels = 100,
                       .maxModels = 64,
                       .maxMemory = 64 << 20}};
}

inline std::span<const std::byte> asBytes(const std::uint8_t* data, std::size_t size) {
    return std::as_bytes(std::span(data, size));
}

inline void require(bool holds) {
    if (!holds) std::abort();
}

/// An error must say something, and JSON must be able to carry it: `dump` throws otherwise.
inline void requireGoodError(const core::Error& error) {
    require(!error.message.empty());
    require(error.code != core::ErrorCode::internal);
    require(!nlohmann::json{error.message, error.field}.dump().empty());
}

}  // namespace rivage::fuzz
