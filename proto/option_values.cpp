#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <set>

#include "proto/emboss_values.h"
#include "proto/option_table.h"

namespace rivage::proto {
namespace {

using core::ErrorCode;
using core::fail;
using core::LabelRule;
using core::RegionWeights;
using core::Result;
using core::Vec3d;
using core::Vec3i;

constexpr std::size_t kMaxLabelName = 64;
constexpr std::size_t kMaxLabelValues = 65536;
constexpr std::size_t kMaxWeightedRegions = 4096;

std::string pointer(const OptionInfo& info) { return "/options/" + info.name; }

/// A number as people write it: 0.5, 5000, 1e-06.
std::string shortest(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return {text, end};
}

std::string listed(const std::vector<std::string>& words) {
    std::string text;
    for (std::size_t i = 0; i < words.size(); ++i)
        text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
    return text;
}

tl::unexpected<core::Error> refuse(const OptionInfo& info, const std::string& given) {
    std::string message = info.name + " must be " + allowedValues(info) + ", not " + given;
    if (!info.words.empty() && given.size() > 2) {
        const std::string near =
            nearestName(std::string_view(given).substr(1, given.size() - 2), info.words);
        if (!near.empty()) message += "; did you mean " + near + "?";
    }
    return fail(ErrorCode::invalidOption, std::move(message), pointer(info));
}

std::string shown(const Json& value) {
    if (value.is_string()) return inQuotes(value.get_ref<const std::string&>());
    if (value.is_object()) return "an object";
    if (value.is_array()) return "a list";
    return writeJson(value);
}

template <typename Number>
std::optional<Number> readNumber(std::string_view text) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<Word> readWord(const OptionInfo& info, std::string_view text) {
    const auto found = std::find(info.words.begin(), info.words.end(), text);
    if (found == info.words.end()) return std::nullopt;
    return Word{static_cast<std::size_t>(found - info.words.begin())};
}

bool fits(const OptionInfo& info, double value) {
    if (!std::isfinite(value) || value < info.minimum || value > info.maximum) return false;
    return info.type != OptionType::integer || value == std::floor(value);
}

std::optional<Vec3i> readDims(const OptionInfo& info, std::string_view text) {
    Vec3i dims;
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t end = axis < 2 ? text.find('x') : text.size();
        if (end == std::string_view::npos) return std::nullopt;
        const auto size = readNumber<int>(text.substr(0, end));
        if (!size || !fits(info, *size)) return std::nullopt;
        dims[axis] = *size;
        text.remove_prefix(std::min(text.size(), end + 1));
    }
    return dims;
}

std::optional<Vec3i> readJsonDims(const OptionInfo& info, const Json& value) {
    if (value.is_string())
        return readDims(info, std::string_view(value.get_ref<const std::string&>()));
    if (!value.is_array() || value.size() != 3) return std::nullopt;
    Vec3i dims;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!value[axis].is_number_integer() || !fits(info, value[axis].get<double>()))
            return std::nullopt;
        dims[static_cast<int>(axis)] = value[axis].get<int>();
    }
    return dims;
}

bool isSpacing(const OptionInfo& info, const Vec3d& sides) {
    return fits(info, sides[0]) && fits(info, sides[1]) && fits(info, sides[2]) &&
           sides.maxCoeff() <= core::kMaxSpacingRatio * sides.minCoeff();
}

std::optional<Vec3d> readSpacing(const OptionInfo& info, std::string_view text) {
    Vec3d sides;
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t end = axis < 2 ? text.find('x') : text.size();
        if (end == std::string_view::npos) return std::nullopt;
        const auto side = readNumber<double>(text.substr(0, end));
        if (!side) return std::nullopt;
        sides[axis] = *side;
        text.remove_prefix(std::min(text.size(), end + 1));
    }
    return isSpacing(info, sides) ? std::optional(sides) : std::nullopt;
}

std::optional<Vec3d> readJsonSpacing(const OptionInfo& info, const Json& value) {
    if (value.is_string())
        return readSpacing(info, std::string_view(value.get_ref<const std::string&>()));
    if (!value.is_array() || value.size() != 3) return std::nullopt;
    Vec3d sides;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!value[axis].is_number()) return std::nullopt;
        sides[static_cast<int>(axis)] = value[axis].get<double>();
    }
    return isSpacing(info, sides) ? std::optional(sides) : std::nullopt;
}

/// A fraction as "3" or "1/2", made as small as it goes.
std::optional<core::Scale> readRatio(std::string_view text) {
    const std::size_t slash = text.find('/');
    const auto up = readNumber<int>(text.substr(0, slash));
    const auto down = slash == std::string_view::npos ? std::optional(1)
                                                      : readNumber<int>(text.substr(slash + 1));
    if (!up || !down || *up < 1 || *down < 1) return std::nullopt;
    const int common = std::gcd(*up, *down);
    const core::Scale scale{*up / common, *down / common};
    if (std::max(scale.up, scale.down) > core::kMaxScale) return std::nullopt;
    return scale;
}

std::optional<core::Scale> readJsonRatio(const Json& value) {
    if (value.is_string()) return readRatio(std::string_view(value.get_ref<const std::string&>()));
    if (!value.is_number_integer()) return std::nullopt;
    return readRatio(writeJson(value));
}

Result<RegionWeights> readRegion(const OptionInfo& info, const std::string& name,
                                 const Json& factors) {
    if (name.empty() || name.size() > kMaxLabelName)
        return refuse(info, "a name of " + std::to_string(name.size()) + " bytes");
    if (!factors.is_object() || factors.empty())
        return refuse(info, shown(factors) + " for " + inQuotes(name));
    RegionWeights region{.region = name};
    for (const auto& [weight, factor] : factors.items()) {
        double* target = weight == "alpha"   ? &region.alpha
                         : weight == "beta"  ? &region.beta
                         : weight == "gamma" ? &region.gamma
                                             : nullptr;
        if (!target) return refuse(info, "the factor " + inQuotes(weight));
        if (!factor.is_number() || !fits(info, factor.get<double>()))
            return refuse(info, shown(factor) + " for " + inQuotes(name));
        *target = factor.get<double>();
    }
    return region;
}

Result<OptionValue> readWeights(const OptionInfo& info, const Json& map) {
    if (map.empty()) return refuse(info, "an empty map");
    if (map.size() > kMaxWeightedRegions)
        return refuse(info, "more than " + std::to_string(kMaxWeightedRegions) + " regions");
    std::vector<RegionWeights> regions;
    for (const auto& [name, factors] : map.items()) {
        auto region = readRegion(info, name, factors);
        if (!region) return fail(region.error());
        regions.push_back(*std::move(region));
    }
    return regions;
}

/// The values of one label; each may belong to one label only.
Result<void> readRule(const OptionInfo& info, const Json& given, std::set<std::uint32_t>& taken,
                      LabelRule& rule) {
    if (given == "*") {
        rule.rest = true;
        return {};
    }
    const Json list = given.is_array() ? given : Json::array({given});
    if (list.empty()) return refuse(info, "an empty list for " + inQuotes(rule.name));
    for (const Json& value : list) {
        if (!value.is_number_integer() || !fits(info, value.get<double>()))
            return refuse(info, shown(value) + " for " + inQuotes(rule.name));
        rule.values.push_back(value.get<std::uint32_t>());
        if (!taken.insert(rule.values.back()).second)
            return fail(ErrorCode::invalidOption,
                        "labels gives the value " + writeJson(value) + " to two labels",
                        pointer(info) + "/" + rule.name);
        if (taken.size() > kMaxLabelValues)
            return refuse(info, "more than " + std::to_string(kMaxLabelValues) + " values");
    }
    return {};
}

Result<OptionValue> readLabelMap(const OptionInfo& info, const Json& map) {
    if (map.empty()) return refuse(info, "an empty map");
    std::vector<LabelRule> rules;
    std::set<std::uint32_t> taken;
    bool rest = false;
    for (const auto& [name, given] : map.items()) {
        if (name.empty() || name.size() > kMaxLabelName)
            return refuse(info, "a name of " + std::to_string(name.size()) + " bytes");
        LabelRule rule{name, {}, false};
        if (auto read = readRule(info, given, taken, rule); !read) return fail(read.error());
        if (rule.rest && std::exchange(rest, true))
            return fail(ErrorCode::invalidOption, "labels gives \"*\" to two labels",
                        pointer(info));
        rules.push_back(std::move(rule));
    }
    return rules;
}

Result<OptionValue> readMap(const OptionInfo& info, const Json& map) {
    if (info.type == OptionType::emboss) return readEmboss(info.name, map);
    return info.type == OptionType::labels ? readLabelMap(info, map) : readWeights(info, map);
}

Result<OptionValue> readMap(const OptionInfo& info, std::string_view text) {
    auto map = readJson(text, pointer(info));
    if (!map) {
        map.error().code = ErrorCode::invalidOption;
        return fail(map.error());
    }
    return readMap(info, *map);
}

}  // namespace

std::string allowedValues(const OptionInfo& info) {
    const std::string range = shortest(info.minimum) + " to " + shortest(info.maximum);
    const std::string orWords = info.words.empty() ? "" : ", or " + listed(info.words);
    switch (info.type) {
        case OptionType::choice: return listed(info.words);
        case OptionType::flag: return "true or false";
        case OptionType::integer: return "an integer from " + range + orWords;
        case OptionType::number: return "a number from " + range + orWords;
        case OptionType::dims: return "three sizes from " + range + " such as 64x68x40";
        case OptionType::labels:
            return listed(info.words) + ", or a map such as {\"sea\":[12,13],\"island\":\"*\"}";
        case OptionType::spacing:
            return "auto, or three sides from " + range + " such as 1x1x2.5, the longest at most " +
                   shortest(core::kMaxSpacingRatio) + " times the shortest";
        case OptionType::weights:
            return "a map such as {\"sea\":{\"alpha\":10},\"*\":{\"gamma\":2}} with factors from " +
                   range;
        case OptionType::ratio:
            return "a fraction of numbers from 1 to " + std::to_string(core::kMaxScale) +
                   " such as 3, 1/2 or 2/3";
        case OptionType::emboss:
            return listed(info.words) +
                   ", or a map such as "
                   "{\"plaster\":\"brick\",\"*\":{\"tile\":\"planks\",\"size\":6}}";
    }
    return {};
}

Result<OptionValue> parseValue(const OptionInfo& info, std::string_view text) {
    const auto word = readWord(info, text);
    switch (info.type) {
        case OptionType::choice:
            if (word) return *word;
            break;
        case OptionType::flag:
            if (text == "true" || text == "false") return text == "true";
            break;
        case OptionType::integer:
        case OptionType::number:
            if (word) return *word;
            if (const auto number = readNumber<double>(text); number && fits(info, *number))
                return *number;
            break;
        case OptionType::dims:
            if (const auto dims = readDims(info, text)) return *dims;
            break;
        case OptionType::spacing:
            if (word) return *word;
            if (const auto sides = readSpacing(info, text)) return *sides;
            break;
        case OptionType::ratio:
            if (const auto ratio = readRatio(text)) return *ratio;
            break;
        case OptionType::labels:
        case OptionType::weights:
        case OptionType::emboss:
            if (word) return *word;
            if (text.starts_with('{')) return readMap(info, text);
            break;
    }
    return refuse(info, inQuotes(text));
}

Result<OptionValue> parseValue(const OptionInfo& info, const Json& value) {
    const auto word =
        value.is_string() ? readWord(info, value.get_ref<const std::string&>()) : std::nullopt;
    switch (info.type) {
        case OptionType::choice:
            if (word) return *word;
            break;
        case OptionType::flag:
            if (value.is_boolean()) return value.get<bool>();
            break;
        case OptionType::integer:
        case OptionType::number:
            if (word) return *word;
            if (value.is_number() && fits(info, value.get<double>())) return value.get<double>();
            break;
        case OptionType::dims:
            if (const auto dims = readJsonDims(info, value)) return *dims;
            break;
        case OptionType::labels:
        case OptionType::emboss:
            if (word) return *word;
            if (value.is_object()) return readMap(info, value);
            break;
        case OptionType::spacing:
            if (word) return *word;
            if (const auto sides = readJsonSpacing(info, value)) return *sides;
            break;
        case OptionType::weights:
            if (value.is_object()) return readMap(info, value);
            break;
        case OptionType::ratio:
            if (const auto ratio = readJsonRatio(value)) return *ratio;
            break;
    }
    return refuse(info, shown(value));
}

std::string nearestName(std::string_view text, const std::vector<std::string>& names) {
    if (text.size() > 64) return {};
    std::string nearest;
    // Two slips are a swap of letters; in a short word they make another word.
    std::size_t best = (text.size() < 4 ? 1 : std::max<std::size_t>(2, text.size() / 3)) + 1;
    for (const std::string& name : names) {
        std::vector<std::size_t> row(name.size() + 1);
        for (std::size_t j = 0; j <= name.size(); ++j) row[j] = j;
        for (std::size_t i = 1; i <= text.size(); ++i) {
            std::size_t diagonal = std::exchange(row[0], i);
            for (std::size_t j = 1; j <= name.size(); ++j) {
                const std::size_t replaced = diagonal + (text[i - 1] != name[j - 1]);
                diagonal = std::exchange(row[j], std::min({replaced, row[j] + 1, row[j - 1] + 1}));
            }
        }
        if (row.back() < best) {
            best = row.back();
            nearest = name;
        }
    }
    return nearest;
}

}  // namespace rivage::proto
