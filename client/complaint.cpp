#include "client/complaint.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "proto/json.h"
#include "proto/option_table.h"

namespace rivage::client {
namespace {

void addOptionNames(const CLI::App& command, std::vector<std::string>& names) {
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back(name);
}

/// The option that was perhaps meant by the first one that neither the command has nor those above
/// and below it.
std::string meant(const CLI::App& command, const std::vector<std::string>& arguments) {
    std::vector<std::string> known;
    for (const CLI::App* app = &command; app != nullptr; app = app->get_parent())
        addOptionNames(*app, known);
    for (const CLI::App* below : command.get_subcommands({})) addOptionNames(*below, known);
    for (const std::string& argument : arguments) {
        if (!argument.starts_with("--") || argument.size() < 3) continue;
        const std::string name = argument.substr(2, argument.find('=') - 2);
        if (std::count(known.begin(), known.end(), name) > 0) continue;
        const std::string near = proto::nearestName(name, known);
        return near.empty() ? std::string() : "; did you mean --" + near + "?";
    }
    return {};
}

}  // namespace

std::string complaint(const CLI::App& app, const std::vector<std::string>& arguments,
                      const CLI::ParseError& error) {
    const auto word = std::find_if(arguments.begin(), arguments.end(),
                                   [](const std::string& text) { return !text.starts_with('-'); });
    const bool missing = word == arguments.end();
    std::string known;
    for (const CLI::App* command : app.get_subcommands({})) {
        if (!missing && command->get_name() == *word)
            return error.what() + meant(*command, arguments);
        known += (known.empty() ? "" : ", ") + command->get_name();
    }
    if (error.get_name() != "RequiredError") return error.what();
    return (missing ? "a command is missing" : "there is no command " + proto::inQuotes(*word)) +
           "; there are " + known;
}

}  // namespace rivage::client
