#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/options.h"
#include "core/base/result.h"
#include "proto/json.h"

/// The map of the option `emboss`: materials to height tiles. Internal to `proto/`.
namespace rivage::proto {

/// The words of the option: none, then the tiles in the order of `core::TileKind`.
[[nodiscard]] const std::vector<std::string>& embossWords();

/// Reads {"plaster": "brick", "*": {"tile": "planks", "size": 6}}.
/// @param name  of the option, for errors
/// @errors invalidOption, with the material and what it may be
core::Result<std::vector<core::EmbossRule>> readEmboss(const std::string& name, const Json& map);

/// The map again; a word where one says it all.
[[nodiscard]] Json embossJson(const std::vector<core::EmbossRule>& rules);

}  // namespace rivage::proto
