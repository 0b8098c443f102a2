#include "client/option_help.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "client/printable.h"
#include "client/report_table.h"
#include "proto/option_table.h"

namespace rivage::client {
namespace {

using proto::Json;

/// The wire has no words for presets; those of a server that is newer than this are shown without.
constexpr std::array<std::pair<const char*, const char*>, 5> kPresets{
    {{"studio",
      "Voxel art of any kind: slopes become smooth, walls stay straight up to sharp edges."},
     {"architectural", "Buildings, small characters: keeps small square parts best."},
     {"organic", "Soft shapes: rounds every edge."},
     {"paper", "As in the publication: no displacement limit, so thin parts may shrink."},
     {"noisy", "Segmentations with wrong voxels: vertices move up to 1.5 voxels."}}};

std::string sentenceOf(const std::string& preset) {
    for (const auto& [name, sentence] : kPresets)
        if (preset == name) return sentence;
    return {};
}

std::string valueText(const Json& value) {
    return printable(value.is_string() ? value.get<std::string>() : proto::writeJson(value));
}

std::string flagOf(const Json& option) {
    std::string flag = "--" + textOf(option, "name");
    std::replace(flag.begin(), flag.end(), '_', '-');
    return printable(flag);
}

std::string line(const std::string& name, const std::string& text) {
    constexpr std::size_t kName = 23;
    return "  " + name + std::string(name.size() < kName ? kName - name.size() : 1, ' ') + text +
           "\n";
}

OptionHelp explain(const Json& option) {
    OptionHelp help{option, optionTable({{"options", Json::array({option})}})};
    if (const std::string needs = textOf(option, "only_with"); !needs.empty())
        help.text += line("", "Needs " + printable(needs) + ".");
    const Json presets = option.value("presets", Json::object());
    for (const auto& [preset, value] : presets.items())
        help.text += line("", "With --preset " + printable(preset) + " " + valueText(value) + ".");
    if (textOf(option, "name") != "preset") return help;
    help.text += "\n";
    for (const Json& preset : option.value("values", Json::array()))
        if (preset.is_string())
            help.text += line(valueText(preset), sentenceOf(preset.get<std::string>()));
    return help;
}

/// A preset: its sentence, and what it sets to something else than the default.
OptionHelp explainPreset(const std::string& name, const Json& options) {
    OptionHelp help{{{"preset", name}, {"description", sentenceOf(name)}},
                    "--preset " + printable(name) + "\n" + line("", sentenceOf(name))};
    Json sets = Json::object();
    for (const Json& option : options) {
        const Json presets = option.value("presets", Json::object());
        const auto value = presets.find(name);
        if (value == presets.end()) continue;
        sets[textOf(option, "name")] = *value;
        help.text += line(flagOf(option), valueText(*value));
    }
    help.json["options"] = std::move(sets);
    return help;
}

bool isPreset(const Json& options, const std::string& name) {
    for (const Json& option : options)
        if (textOf(option, "name") == "preset")
            for (const Json& value : option.value("values", Json::array()))
                if (value == Json(name)) return true;
    return false;
}

}  // namespace

Outcome<OptionHelp> explainOption(const Json& answer, std::string name) {
    if (name.starts_with("--")) name.erase(0, 2);
    std::replace(name.begin(), name.end(), '-', '_');
    const Json given = answer.value("options", Json::array());
    std::vector<std::string> known;
    Json options = Json::array();
    for (const Json& option : given)
        if (option.is_object()) options.push_back(option);
    for (const Json& option : options) {
        if (textOf(option, "name") == name) return explain(option);
        known.push_back(textOf(option, "name"));
    }
    if (isPreset(options, name)) return explainPreset(name, options);
    const std::string near = proto::nearestName(name, known);
    return fail(ExitCode::usage, "There is no option or preset " + proto::inQuotes(name),
                near.empty() ? "'rivage options' lists them" : "did you mean " + near + "?");
}

}  // namespace rivage::client
