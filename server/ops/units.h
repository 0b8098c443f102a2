#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "core/base/result.h"

namespace rivage::server {

/// "64MiB", "1.5G", "4096" -> bytes. @errors invalidOption
core::Result<std::uint64_t> parseBytes(const std::string& text);

/// "30", "30s", "5m", "1h", "250ms" rounded up -> seconds. @errors invalidOption
core::Result<std::chrono::seconds> parseDuration(const std::string& text);

}  // namespace rivage::server
