#include "proto/options.h"

#include <algorithm>

#include "proto/option_table.h"

namespace rivage::proto {
namespace {

using core::ErrorCode;
using core::fail;
using core::Result;

/// An option that was given, with its value read.
struct Given {
    const Option* option;
    OptionValue value;
};

Result<const Option*> findOption(const std::string& name) {
    std::vector<std::string> names;
    for (const Option& option : optionTable()) {
        if (option.info.name == name) return &option;
        names.push_back(option.info.name);
    }
    std::string message = "there is no option " + inQuotes(name);
    const std::string near = nearestName(name, names);
    if (!near.empty()) message += "; did you mean " + near + "?";
    const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
    });
    return fail(ErrorCode::unknownOption, std::move(message),
                plain && name.size() <= 64 ? "/options/" + name : "/options");
}

/// Reads one option into `given`, and refuses it if it is there already.
template <typename Value>
Result<void> readOption(const std::string& name, const Value& value, std::vector<Given>& given) {
    const auto option = findOption(name);
    if (!option) return fail(option.error());
    for (const Given& other : given)
        if (other.option == *option)
            return fail(ErrorCode::invalidOption, name + " is given twice", "/options/" + name);
    auto read = parseValue((*option)->info, value);
    if (!read) return fail(read.error());
    given.push_back({*option, *std::move(read)});
    return {};
}

Result<void> readJsonOptions(std::string_view json, std::vector<Given>& given) {
    auto object = readJson(json, "/options");
    if (!object) return fail(object.error());
    if (!object->is_object())
        return fail(ErrorCode::malformedRequest, "the options must be a JSON object", "/options");
    for (const auto& [name, value] : object->items())
        if (auto read = readOption(name, value, given); !read) return read;
    return {};
}

/// Nothing is ignored in silence: an option without effect is refused.
Result<void> checkTogether(const JobOptions& options, const std::vector<Given>& given) {
    for (const Given& one : given) {
        const OptionInfo& info = one.option->info;
        if (one.option->applies && !one.option->applies(options))
            return fail(ErrorCode::invalidOption,
                        info.name + " has an effect with " + info.onlyWith + " only",
                        "/options/" + info.name);
    }
    const core::InputOptions& input = options.conversion.input;
    if (input.format == core::GridFormat::raw && !input.dims)
        return fail(ErrorCode::invalidOption, "format=raw needs dims, such as dims=64x68x40",
                    "/options/dims");
    return {};
}

JobOptions defaults() {
    JobOptions options;
    options.conversion.method = core::presetOptions(options.conversion.preset);
    return options;
}

/// How a job runs is told only where it is not as usual.
Json effective(const JobOptions& options) {
    const JobOptions usual = defaults();
    Json object = Json::object();
    for (const Option& option : optionTable()) {
        if (option.applies && !option.applies(options)) continue;
        Json value = option.get(options);
        if (option.info.group == "run" && value == option.get(usual)) continue;
        if (!value.is_null()) object[option.info.name] = std::move(value);
    }
    return object;
}

const char* typeName(OptionType type) {
    switch (type) {
        case OptionType::choice: return "choice";
        case OptionType::flag: return "flag";
        case OptionType::integer: return "integer";
        case OptionType::number: return "number";
        case OptionType::dims: return "dims";
        case OptionType::labels: return "labels";
        case OptionType::spacing: return "spacing";
        case OptionType::weights: return "weights";
        case OptionType::ratio: return "ratio";
        case OptionType::emboss: return "emboss";
    }
    return "";
}

/// What the other presets set this option to, where that differs from the default.
Json presetDefaults(const Option& option, const Json& normal) {
    Json presets = Json::object();
    for (const Option& other : optionTable()) {
        if (other.info.name != "preset") continue;
        for (std::size_t i = 0; i < other.info.words.size(); ++i) {
            JobOptions options = defaults();
            other.set(options, Word{i});
            const Json value = option.get(options);
            if (value != normal && &option != &other) presets[other.info.words[i]] = value;
        }
    }
    return presets;
}

}  // namespace

std::vector<OptionInfo> optionInfos() {
    std::vector<OptionInfo> infos;
    for (const Option& option : optionTable()) infos.push_back(option.info);
    return infos;
}

Result<JobOptions> parseOptions(std::span<const OptionText> text, std::string_view json) {
    std::vector<Given> given;
    for (const OptionText& option : text)
        if (auto read = readOption(option.name, std::string_view(option.value), given); !read)
            return fail(read.error());
    if (!json.empty())
        if (auto read = readJsonOptions(json, given); !read) return fail(read.error());

    std::stable_partition(given.begin(), given.end(),
                          [](const Given& one) { return one.option->info.name == "preset"; });
    JobOptions options = defaults();
    for (const Given& one : given) one.option->set(options, one.value);
    if (auto checked = checkTogether(options, given); !checked) return fail(checked.error());
    return options;
}

Json toJson(const core::ConversionOptions& options) { return effective(JobOptions{options, {}}); }

Json toJson(const JobOptions& options) { return effective(options); }

Json describeOptions() {
    const JobOptions normal = defaults();
    Json list = Json::array();
    for (const Option& option : optionTable()) {
        const OptionInfo& info = option.info;
        Json entry{{"name", info.name}, {"group", info.group}, {"type", typeName(info.type)}};
        if (!info.words.empty()) entry["values"] = info.words;
        if (info.type != OptionType::choice && info.type != OptionType::flag &&
            info.type != OptionType::emboss) {
            const bool whole = info.type == OptionType::integer || info.type == OptionType::dims ||
                               info.type == OptionType::labels;
            entry["minimum"] =
                whole ? Json(static_cast<std::int64_t>(info.minimum)) : Json(info.minimum);
            entry["maximum"] =
                whole ? Json(static_cast<std::int64_t>(info.maximum)) : Json(info.maximum);
        }
        entry["default"] = option.get(normal);
        if (Json presets = presetDefaults(option, entry["default"]); !presets.empty())
            entry["presets"] = std::move(presets);
        if (!info.onlyWith.empty()) entry["only_with"] = info.onlyWith;
        entry["description"] = info.sentence;
        list.push_back(std::move(entry));
    }
    return Json{{"options", std::move(list)}};
}

}  // namespace rivage::proto
