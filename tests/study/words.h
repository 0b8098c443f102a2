#pragma once

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/study/statistics.h"

/// Figures and tables as Markdown.
namespace rivage::study {

[[nodiscard]] inline std::string decimals(double value, int digits) {
    if (std::isnan(value)) return "-";
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    // No "-0.00".
    if (text[0] == '-' && std::string(text).find_first_not_of("-0.") == std::string::npos)
        return text + 1;
    return text;
}

/// "0.079 +- 0.004".
[[nodiscard]] inline std::string words(const Interval& interval, int digits) {
    if (std::isnan(interval.half)) return decimals(interval.mean, digits);
    return decimals(interval.mean, digits) + " +- " + decimals(interval.half, digits);
}

/// "0.31 (0.28 to 0.34)".
[[nodiscard]] inline std::string words(const Ratio& ratio) {
    if (std::isnan(ratio.low)) return decimals(ratio.value, 2);
    return decimals(ratio.value, 2) + " (" + decimals(ratio.low, 2) + " to " +
           decimals(ratio.high, 2) + ")";
}

[[nodiscard]] inline std::string row(const std::vector<std::string>& cells) {
    std::string text = "|";
    for (const std::string& cell : cells) text += " " + cell + " |";
    return text + "\n";
}

[[nodiscard]] inline std::string head(const std::vector<std::string>& cells) {
    return row(cells) + row(std::vector<std::string>(cells.size(), "---"));
}

[[nodiscard]] inline std::string joined(const std::vector<std::string>& items) {
    std::string text;
    for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
    return text;
}

}  // namespace rivage::study
