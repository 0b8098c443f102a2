#pragma once

#include <string>
#include <string_view>

namespace rivage::core {

/// Text of a file as it may appear in JSON and in glTF: valid UTF-8 without control characters.
/// Every byte that breaks this becomes '?'; the result is cut to `kMaxTextBytes`.
inline constexpr std::size_t kMaxTextBytes = 128;
[[nodiscard]] std::string cleanText(std::string_view text);

}  // namespace rivage::core
