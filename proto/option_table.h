#pragma once

#include <functional>
#include <variant>
#include <vector>

#include "proto/options.h"

/// The one table behind parseOptions, toJson and describeOptions. Internal to `proto/`.
namespace rivage::proto {

/// A value that fits its option. The index of a word is the index in `OptionInfo::words`.
struct Word {
    std::size_t index = 0;
};
using OptionValue =
    std::variant<Word, bool, double, core::Vec3i, std::vector<core::LabelRule>, core::Vec3d,
                 std::vector<core::RegionWeights>, core::Scale, std::vector<core::EmbossRule>>;

struct Option {
    OptionInfo info;
    std::function<void(JobOptions&, const OptionValue&)> set;
    std::function<Json(const JobOptions&)> get;  ///< null where it is not in force
    /// Whether the option has an effect beside the others; none: always.
    std::function<bool(const JobOptions&)> applies = {};
};

[[nodiscard]] const std::vector<Option>& optionTable();

/// The part of the table that is about results: relief, format, compression.
void addResultOptions(std::vector<Option>& table);

/// Reads a value as text ("0.5", "draco", "64x68x40") for one option.
/// @errors invalidOption, with the name, what is allowed and what was given
core::Result<OptionValue> parseValue(const OptionInfo& info, std::string_view text);

/// Reads a JSON value for one option; numbers and booleans must have their JSON types.
/// @errors invalidOption, as above
core::Result<OptionValue> parseValue(const OptionInfo& info, const Json& value);

/// What an option takes, e.g. "a number from 0.5 to 32, or auto".
[[nodiscard]] std::string allowedValues(const OptionInfo& info);

/// The one of `names` that `text` was probably meant to be, or an empty string.
[[nodiscard]] std::string nearestName(std::string_view text, const std::vector<std::string>& names);

}  // namespace rivage::proto
