#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/options.h"
#include "core/base/result.h"
#include "proto/json.h"

namespace rivage::proto {

/// How a job runs, beside what it converts.
struct RunOptions {
    std::optional<std::uint64_t> deadlineMs;  ///< from acceptance to the end; none: the server's
    bool progressive = false;                 ///< previews are made while the solver runs
};

/// Everything that a client can ask for with one grid.
struct JobOptions {
    core::ConversionOptions conversion = {};
    RunOptions run = {};
};

enum class OptionType : std::uint8_t {
    choice,   ///< one of `words`
    flag,     ///< true or false
    integer,  ///< minimum..maximum, or one of `words`
    number,   ///< minimum..maximum, or one of `words`
    dims,     ///< three sizes, "64x68x40" or [64, 68, 40]
    labels,   ///< one of `words`, or a map from names to lists of values or "*"
    spacing,  ///< three numbers, "1x1x2.5" or [1, 1, 2.5]
    weights,  ///< a map from names or "*" to factors of alpha, beta, gamma
    ratio,    ///< a fraction, "3" or "1/2", or the number 3
    emboss,   ///< one of `words`, or a map from materials or "*" to height tiles
};

/// What users need to know about one option.
struct OptionInfo {
    std::string name;
    std::string group;  ///< "input", "method", "transfer", "output", "run"
    OptionType type = OptionType::choice;
    std::vector<std::string> words = {};
    double minimum = 0;
    double maximum = 0;
    std::string sentence = {};
    std::string onlyWith = {};  ///< what it needs beside it, e.g. "format=raw"; empty: nothing
};

/// An option as text, as it comes from a query or a command line.
struct OptionText {
    std::string name;
    std::string value;
};

/// Every option, in the order in which they are shown.
[[nodiscard]] std::vector<OptionInfo> optionInfos();

/// Reads options given as text and as a JSON object; both may be empty. The preset is applied
/// first, whatever its place, and what is given beside it wins.
/// @param json  an object of options, or empty
/// @errors unknownOption; invalidOption if a value is malformed or out of range, an option is given
///         twice, or options contradict each other; malformedRequest if the text is not JSON
core::Result<JobOptions> parseOptions(std::span<const OptionText> text, std::string_view json = {});

/// The conversion options in force, by name, as they are echoed in the report: feeding them back
/// gives the same conversion.
[[nodiscard]] Json toJson(const core::ConversionOptions& options);

/// As above, with the run options that were given.
[[nodiscard]] Json toJson(const JobOptions& options);

/// The answer of GET /v1/options: every option with type, range, default and one sentence.
[[nodiscard]] Json describeOptions();

}  // namespace rivage::proto
