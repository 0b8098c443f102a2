#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace rivage::proto {

using Json = nlohmann::ordered_json;

/// Limits of a JSON text that a client sends.
struct JsonLimits {
    std::size_t maxBytes = 64 << 10;
    std::size_t maxDepth = 32;      ///< nested arrays and objects
    std::size_t maxMembers = 5000;  ///< of one object
};

/// Reads a JSON text that nobody vouches for: depth and size are bounded, a member may occur once,
/// numbers are finite, nothing follows the value.
/// @param field  JSON pointer of the text itself, put into errors
/// @errors       malformedRequest
/// @cost         O(bytes), no recursion
core::Result<Json> readJson(std::string_view text, const std::string& field,
                            const JsonLimits& limits = {});

/// The JSON text of a value on one line; bytes that are not UTF-8 become U+FFFD.
[[nodiscard]] std::string writeJson(const Json& value);

/// What a client sent, fit for a message: at most 64 bytes, control characters as '?', in quotes.
[[nodiscard]] std::string inQuotes(std::string_view text);

}  // namespace rivage::proto
