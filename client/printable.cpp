#include "client/printable.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

namespace rivage::client {
namespace {

constexpr char32_t kNone = 0xFFFFFFFF;  ///< no character: a byte that is no UTF-8

/// A character at the start of a text, and the bytes that it takes.
struct Character {
    char32_t code = kNone;
    std::size_t bytes = 1;
};

/// @source  RFC 3629: no overlong forms, no surrogates, nothing beyond U+10FFFF
Character firstOf(std::string_view text) {
    const auto lead = static_cast<unsigned char>(text.front());
    if (lead < 0x80) return {lead, 1};
    const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {};
    char32_t code = lead & (0xFFU >> (bytes + 1));
    for (std::size_t i = 1; i < bytes; ++i) {
        const auto next = static_cast<unsigned char>(text[i]);
        if ((next & 0xC0) != 0x80) return {};
        code = (code << 6) | (next & 0x3FU);
    }
    const bool overlong = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
    if (overlong || (code >= 0xD800 && code < 0xE000) || code > 0x10FFFF) return {};
    return {code, bytes};
}

/// Whether a character steers a terminal, or the order in which it shows the others.
bool isControl(char32_t code) {
    if (code < 0x20 || (code >= 0x7F && code < 0xA0)) return true;
    return code == 0x061C || code == 0x200E || code == 0x200F ||
           (code >= 0x2028 && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
}

}  // namespace

std::string printable(std::string_view text) {
    std::string shown;
    shown.reserve(text.size());
    while (!text.empty()) {
        const Character next = firstOf(text);
        if (next.code == kNone || isControl(next.code))
            shown += '?';
        else
            shown += text.substr(0, next.bytes);
        text.remove_prefix(next.bytes);
    }
    return shown;
}

std::string cutTo(std::string_view text, std::size_t most) {
    std::size_t end = std::min(text.size(), most);
    while (end > 0 && end < text.size() && (text[end] & 0xC0) == 0x80) --end;
    return std::string(text.substr(0, end));
}

std::string jsonLine(const proto::Json& json) {
    const std::string plain = proto::writeJson(json);
    std::string line;
    line.reserve(plain.size() + 1);
    for (std::string_view rest = plain; !rest.empty();) {
        const Character next = firstOf(rest);
        char escape[8];
        std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned>(next.code & 0xFFFF));
        line += isControl(next.code) ? std::string_view(escape) : rest.substr(0, next.bytes);
        rest.remove_prefix(next.bytes);
    }
    return line + "\n";
}

}  // namespace rivage::client
