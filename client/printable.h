#pragma once

#include <string>
#include <string_view>

#include "proto/json.h"

namespace rivage::client {

/// One line of text that is safe to show: what servers, files and file names say may hold escape
/// sequences. Control characters (C0 with line breaks, DEL, C1), marks that turn the direction of
/// writing, and bytes that are no UTF-8 become '?', one each.
[[nodiscard]] std::string printable(std::string_view text);

/// Text cut to at most `most` bytes, not inside of a character.
[[nodiscard]] std::string cutTo(std::string_view text, std::size_t most);

/// JSON on one line, with the end of the line. What `printable` would replace is escaped, so that
/// it is the same document, and yet safe on a terminal.
[[nodiscard]] std::string jsonLine(const proto::Json& json);

}  // namespace rivage::client
