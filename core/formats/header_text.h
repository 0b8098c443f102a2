#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace rivage::core {

/// A piece of a text header without the blanks around it.
[[nodiscard]] inline std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r";
    const std::size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

/// The number that a text is; nothing if it is none, or does not fit.
template <typename Number>
[[nodiscard]] std::optional<Number> numberIn(std::string_view text) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace rivage::core
