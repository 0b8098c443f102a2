#include "server/ops/units.h"

#include <charconv>
#include <cmath>
#include <map>
#include <optional>

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// A number and the unit behind it.
struct Quantity {
    double value = 0;
    std::string unit;
};

std::optional<Quantity> readQuantity(const std::string& text) {
    Quantity quantity;
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, quantity.value);
    if (error != std::errc() || !(quantity.value >= 0) || !std::isfinite(quantity.value))
        return std::nullopt;
    quantity.unit.assign(end, last);
    return quantity;
}

}  // namespace

core::Result<std::uint64_t> parseBytes(const std::string& text) {
    static const std::map<std::string, int> kShifts{{"", 0},   {"B", 0},    {"K", 10}, {"KiB", 10},
                                                    {"M", 20}, {"MiB", 20}, {"G", 30}, {"GiB", 30},
                                                    {"T", 40}, {"TiB", 40}};
    const auto quantity = readQuantity(text);
    const auto shift = quantity ? kShifts.find(quantity->unit) : kShifts.end();
    if (shift == kShifts.end())
        return fail(ErrorCode::invalidOption,
                    "\"" + text + "\" is no number of bytes such as 4096, 64MiB or 2G");
    const double bytes = std::ldexp(quantity->value, shift->second);
    if (bytes > 0x1p60) return fail(ErrorCode::invalidOption, "\"" + text + "\" is too much");
    return static_cast<std::uint64_t>(bytes);
}

core::Result<std::chrono::seconds> parseDuration(const std::string& text) {
    static const std::map<std::string, double> kSeconds{{"", 1},   {"ms", 0.001}, {"s", 1},
                                                        {"m", 60}, {"h", 3600},   {"d", 86400}};
    const auto quantity = readQuantity(text);
    const auto unit = quantity ? kSeconds.find(quantity->unit) : kSeconds.end();
    if (unit == kSeconds.end() || quantity->value > 1e9)
        return fail(ErrorCode::invalidOption,
                    "\"" + text + "\" is no duration such as 30s, 5m or 1h");
    return std::chrono::seconds(static_cast<long>(std::ceil(quantity->value * unit->second)));
}

}  // namespace rivage::server
