#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/gltf/private_tinygltf.h"

namespace rivage::core {

/// The text with every byte that is not part of valid UTF-8 replaced by U+FFFD: names come from
/// files, and JSON must be UTF-8.
[[nodiscard]] std::string validUtf8(std::string_view text);

/// JSON as a tinygltf value, for `extras`. Null members and items are left out, for tinygltf has no
/// way to write them; integers beyond 32 bits become floating-point numbers.
[[nodiscard]] tinygltf::Value toValue(const nlohmann::ordered_json& json);

}  // namespace rivage::core
