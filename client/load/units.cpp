#include "client/load/units.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace rivage::client::load {
namespace {

constexpr double kHour = 3.6e9;  // us

std::optional<double> readNumber(std::string_view text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

}  // namespace

std::optional<std::int64_t> readTime(std::string_view text) {
    double scale = 0;
    std::size_t unit = 2;
    if (text.ends_with("us")) {
        scale = 1;
    } else if (text.ends_with("ms")) {
        scale = 1e3;
    } else if (text.ends_with('s')) {
        scale = 1e6;
        unit = 1;
    } else {
        return std::nullopt;
    }
    const auto value = readNumber(text.substr(0, text.size() - unit));
    if (!value || *value <= 0 || *value * scale > kHour) return std::nullopt;
    // Times are whole microseconds: at most 1.5 us is at most 1 us. What is less than the last
    // digit of a double off is meant to be whole.
    const auto whole = static_cast<std::int64_t>(std::floor(*value * scale * (1 + 1e-12)));
    return whole > 0 ? std::optional(whole) : std::nullopt;
}

std::string numberText(double value, int digits) {
    if (!std::isfinite(value)) return "n/a";
    char text[400];  // the largest number has 309 digits before the point
    std::snprintf(text, sizeof text, "%.*f", std::min(digits, 20), value);
    std::string result = text;
    if (digits == 0) return result;
    while (result.ends_with('0')) result.pop_back();
    if (result.ends_with('.')) result.pop_back();
    return result == "-0" ? "0" : result;
}

std::string timeText(std::int64_t microseconds) {
    const auto value = static_cast<double>(microseconds);
    const auto [scale, unit] = value < 1e3   ? std::pair{1.0, " us"}
                               : value < 1e6 ? std::pair{1e3, " ms"}
                                             : std::pair{1e6, " s"};
    const double scaled = value / scale;
    const int digits = scale == 1.0 ? 0 : scaled < 10 ? 2 : scaled < 100 ? 1 : 0;
    char text[64];
    std::snprintf(text, sizeof text, "%.*f%s", digits, scaled, unit);
    return text;
}

std::string timeText(std::optional<std::int64_t> microseconds) {
    return microseconds ? timeText(*microseconds) : "n/a";
}

std::optional<double> readPercentile(std::string_view text) {
    if (!text.starts_with('p')) return std::nullopt;
    const auto value = readNumber(text.substr(1));
    if (!value || *value <= 0 || *value >= 100) return std::nullopt;
    return value;
}

std::string percentileName(double percent) {
    std::array<char, 32> text{};
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), percent);
    return "p" + (error == std::errc() ? std::string(text.data(), end) : numberText(percent));
}

std::optional<Slo> readSlo(std::string_view text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    const auto percent = readPercentile(text.substr(0, equals));
    const auto limit = readTime(text.substr(equals + 1));
    if (!percent || !limit) return std::nullopt;
    return Slo{*percent, *limit};
}

}  // namespace rivage::client::load
