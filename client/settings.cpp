#include "client/settings.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <set>
#include <string_view>

#include "proto/option_table.h"

namespace rivage::client {
namespace {

constexpr std::string_view kPrefix = "RIVAGE_CLIENT_";

tl::unexpected<Failure> refuse(const std::string& place, const std::string& why) {
    return fail(ExitCode::usage, place, why);
}

std::string trimmed(const std::string& text) {
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::string unquoted(const std::string& text) {
    const bool quoted = text.size() >= 2 && (text.front() == '"' || text.front() == '\'') &&
                        text.back() == text.front();
    return quoted ? text.substr(1, text.size() - 2) : text;
}

std::string variable(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? std::string() : value;
}

/// The value of --config, which has to be known before the rest is read.
std::string configArgument(const std::vector<std::string>& arguments) {
    constexpr std::string_view kFlag = "--config";
    for (std::size_t i = 0; i < arguments.size() && arguments[i] != "--"; ++i) {
        const std::string& word = arguments[i];
        if (word == kFlag && i + 1 < arguments.size()) return arguments[i + 1];
        if (word.starts_with(kFlag) && word.substr(kFlag.size()).starts_with('='))
            return word.substr(kFlag.size() + 1);
    }
    return {};
}

std::string defaultFile() {
    const std::string folder = variable("XDG_CONFIG_HOME");
    if (!folder.empty()) return folder + "/rivage/config";
    const std::string home = variable("HOME");
    return home.empty() ? std::string() : home + "/.config/rivage/config";
}

/// The options, of all commands, that may stand in the file.
std::vector<CLI::Option*> configurable(CLI::App& app) {
    std::vector<CLI::App*> apps = app.get_subcommands({});
    apps.insert(apps.begin(), &app);
    std::vector<CLI::Option*> options;
    for (CLI::App* one : apps)
        for (CLI::Option* option : one->get_options())
            if (option->get_configurable() && !option->get_positional()) options.push_back(option);
    return options;
}

std::vector<std::string> namesOf(const std::vector<CLI::Option*>& options) {
    std::vector<std::string> names;
    names.reserve(options.size());
    for (const CLI::Option* option : options) names.push_back(option->get_lnames().front());
    return names;
}

std::string unknown(const std::string& name, const std::vector<std::string>& known) {
    const std::string near = proto::nearestName(name, known);
    return "there is no setting " + proto::inQuotes(name) +
           (near.empty() ? std::string() : "; did you mean " + near + "?");
}

}  // namespace

Outcome<std::vector<Setting>> readSettings(std::istream& stream, const std::string& file) {
    std::vector<Setting> settings;
    std::set<std::string> names;
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number) {
        const std::string place = file + ":" + std::to_string(number);
        constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";  // some editors begin with it
        if (number == 1 && line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
        const std::string text = trimmed(line);
        if (text.empty() || text.starts_with('#')) continue;
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos) return refuse(place, "expected name = value");
        std::string name = trimmed(text.substr(0, equals));
        std::replace(name.begin(), name.end(), '_', '-');
        if (!names.insert(name).second) return refuse(place, name + " is set twice");
        settings.push_back({name, unquoted(trimmed(text.substr(equals + 1))), place});
    }
    if (stream.bad()) return refuse(file, "cannot be read");
    return settings;
}

Outcome<std::vector<Setting>> loadSettings(const std::vector<std::string>& arguments) {
    std::string file = configArgument(arguments);
    if (file.empty()) file = variable("RIVAGE_CONFIG");
    const bool named = !file.empty();
    if (!named) file = defaultFile();
    if (file.empty() || (!named && access(file.c_str(), F_OK) != 0)) return std::vector<Setting>();
    std::ifstream stream(file);
    if (!stream) return refuse(file, "this file of settings cannot be read");
    return readSettings(stream, file);
}

Outcome<void> applySettings(CLI::App& app, const std::vector<Setting>& settings) {
    const std::vector<CLI::Option*> options = configurable(app);
    const std::vector<std::string> names = namesOf(options);
    for (const Setting& setting : settings) {
        bool found = false;
        for (std::size_t i = 0; i < options.size(); ++i) {
            if (names[i] != setting.name) continue;
            found = true;
            try {
                options[i]->run_callback_for_default()->default_val(setting.value);
            } catch (const CLI::Error& error) {
                return refuse(setting.place, error.what());
            }
        }
        if (!found) return refuse(setting.place, unknown(setting.name, names));
    }
    return {};
}

Outcome<void> checkVariables(CLI::App& app) {
    const std::vector<CLI::Option*> options = configurable(app);
    for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry) {
        const std::string_view text(*entry);
        if (!text.starts_with(kPrefix)) continue;
        const std::string name(text.substr(0, text.find('=')));
        const bool known = std::any_of(options.begin(), options.end(), [&](const auto* option) {
            return option->get_envname() == name;
        });
        if (!known) return refuse(name, "this environment variable is no setting");
    }
    return {};
}

}  // namespace rivage::client
