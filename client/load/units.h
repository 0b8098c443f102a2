#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "client/failure.h"

namespace rivage::client::load {

/// Reads "250us", "500ms", "1.5s". @return us, rounded down; nothing if it is no time from 1 us (no
/// clock here tells less) to 1 h
[[nodiscard]] std::optional<std::int64_t> readTime(std::string_view text);

/// A time for a person, with three digits: "31 us", "4.27 ms", "1.05 s".
[[nodiscard]] std::string timeText(std::int64_t microseconds);

/// The same, or "n/a".
[[nodiscard]] std::string timeText(std::optional<std::int64_t> microseconds);

/// What an answer has to keep to count: a percentile of the latency and its limit.
struct Slo {
    double percent = 99;
    std::int64_t limit = 0;  ///< us
};

/// What `readSlo` takes, for complaints.
inline constexpr const char* kSloForm =
    "expected a limit such as p99=500ms: a percentile above p0 and below p100, a time from 1us "
    "(nothing shorter is measured) to 3600s";

/// Reads "p99=500ms". @return nothing if it is not of this form
[[nodiscard]] std::optional<Slo> readSlo(std::string_view text);

/// Reads "p99.9" as 99.9. @return nothing if it is no percentile above 0 and below 100
[[nodiscard]] std::optional<double> readPercentile(std::string_view text);

/// The name that `readPercentile` reads: "p50", "p99.9". Nothing is rounded away.
[[nodiscard]] std::string percentileName(double percent);

/// A number with at most `digits` digits after the point, without zeros at the end.
[[nodiscard]] std::string numberText(double value, int digits = 2);

}  // namespace rivage::client::load
