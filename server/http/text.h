#pragma once

#include <algorithm>
#include <string>
#include <string_view>

/// What the fields of HTTP have in common as texts.
namespace rivage::server {

/// Without the blanks and tabs at both ends.
[[nodiscard]] inline std::string_view trimmed(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
    return text.substr(0, text.find_last_not_of(" \t") + 1);
}

/// ASCII letters in lower case, whatever the locale.
[[nodiscard]] inline std::string lowerCase(std::string_view text) {
    std::string result(text);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c | 0x20);
    return result;
}

}  // namespace rivage::server
