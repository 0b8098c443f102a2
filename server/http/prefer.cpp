#include "server/http/prefer.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "server/http/text.h"

namespace rivage::server {
namespace {

constexpr long kLongestWait = 86400;

std::optional<std::chrono::seconds> readSeconds(std::string_view text) {
    if (text.size() > 2 && text.front() == '"' && text.back() == '"')
        text = text.substr(1, text.size() - 2);
    long seconds = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (error != std::errc() || end != text.data() + text.size() || seconds < 0)
        return std::nullopt;
    return std::chrono::seconds(std::min(seconds, kLongestWait));
}

}  // namespace

std::string Prefer::applied() const {
    std::string text = respondAsync ? "respond-async" : "";
    if (wait) text += (text.empty() ? "" : ", ") + ("wait=" + std::to_string(wait->count()));
    return text;
}

Prefer parsePrefer(const std::string& header) {
    Prefer prefer;
    std::string_view rest = header;
    while (!rest.empty()) {
        const std::size_t comma = std::min(rest.find(','), rest.size());
        // Parameters of a preference, after a semicolon, change nothing for these two.
        const std::string_view item =
            trimmed(rest.substr(0, comma).substr(0, std::min(rest.find(';'), comma)));
        rest.remove_prefix(std::min(comma + 1, rest.size()));
        if (item == "respond-async") prefer.respondAsync = true;
        const std::size_t equals = item.find('=');
        if (equals != std::string_view::npos && trimmed(item.substr(0, equals)) == "wait" &&
            !prefer.wait)
            prefer.wait = readSeconds(trimmed(item.substr(equals + 1)));
    }
    return prefer;
}

}  // namespace rivage::server
