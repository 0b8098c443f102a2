#include "client/command_line.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <utility>

#include "client/command_tree.h"
#include "client/settings.h"

namespace rivage::client {
namespace {

/// What is wrong with a command line that CLI11 refused, naming a command that does not exist.
std::string complaint(const CLI::App& app, const std::vector<std::string>& arguments,
                      const CLI::ParseError& error) {
    const auto word = std::find_if(arguments.begin(), arguments.end(),
                                   [](const std::string& text) { return !text.starts_with('-'); });
    const bool missing = word == arguments.end();
    std::string known;
    for (const CLI::App* command : app.get_subcommands({})) {
        if (!missing && command->get_name() == *word) return error.what();
        known += (known.empty() ? "" : ", ") + command->get_name();
    }
    if (error.get_name() != "RequiredError") return error.what();
    return (missing ? "a command is missing" : "there is no command " + proto::inQuotes(*word)) +
           "; there are " + known;
}

tl::unexpected<ExitCode> complain(Console& console, const std::string& text) {
    console.err << "rivage: " << text << "\nRun with --help for more information.\n";
    return tl::unexpected(ExitCode::usage);
}

/// The key of the file, else that of the environment, else none.
Outcome<std::string> apiKeyOf(const std::string& file) {
    if (!file.empty()) return readApiKey(file);
    const char* key = std::getenv("RIVAGE_API_KEY");
    if (key == nullptr || *key == '\0') return std::string();
    if (!isApiKey(key)) return fail(ExitCode::usage, "RIVAGE_API_KEY holds no API key");
    return std::string(key);
}

/// The options that the command sends: those of the input alone where nothing is converted.
std::vector<proto::OptionText> optionsOf(Command command, const Parsed& parsed) {
    std::vector<proto::OptionText> options;
    if (command != Command::regularize && command != Command::inspect) return options;
    for (const proto::OptionInfo& info : proto::optionInfos()) {
        const auto given = parsed.options.find(info.name);
        if (given != parsed.options.end() &&
            (command == Command::regularize || info.group == "input"))
            options.push_back({info.name, given->second});
    }
    return options;
}

/// Where a value that is refused stands, if that is the file of settings.
std::string placeOf(const core::Error& error, const Parsed& parsed,
                    const std::vector<Setting>& settings) {
    const std::string name = error.field.substr(error.field.rfind('/') + 1);
    const auto value = parsed.options.find(name);
    for (const Setting& setting : settings)
        if (value != parsed.options.end() && flagName(name) == "--" + setting.name &&
            value->second == setting.value)
            return ", as " + setting.place + " says";
    return {};
}

CommandLine finish(const CLI::App& app, Parsed& parsed, const std::vector<Setting>& settings,
                   Console& console) {
    Invocation& invocation = parsed.invocation;
    invocation.command = commandOf(app);
    invocation.timeout =
        std::chrono::milliseconds(static_cast<std::int64_t>(1000 * parsed.seconds));
    auto key = apiKeyOf(parsed.apiKeyFile);
    if (!key) return complain(console, describe(key.error()));
    invocation.apiKey = *std::move(key);
    if (!invocation.caFile.empty() && access(invocation.caFile.c_str(), R_OK) != 0)
        return complain(console, "--ca-file: cannot read " + invocation.caFile);
    invocation.options = optionsOf(invocation.command, parsed);
    if (const auto valid = proto::parseOptions(invocation.options); !valid)
        return complain(console, valid.error().message + placeOf(valid.error(), parsed, settings));
    if (invocation.command == Command::sample) {
        if (parsed.list)
            invocation.command = Command::listSamples;
        else if (invocation.inputs.empty())
            return complain(console, "sample needs NAME or --list");
    }
    return std::move(invocation);
}

}  // namespace

CommandLine parseCommandLine(const std::vector<std::string>& arguments, Console& console) {
    CLI::App app(kProgramSentence, "rivage");
    Parsed parsed;
    describeCommandLine(app, parsed);
    // The file comes first, so that the variables and the command line win over it; but a broken
    // one must not keep --help from being read.
    const auto settings = loadSettings(arguments);
    const auto applied =
        settings ? applySettings(app, *settings) : tl::unexpected(settings.error());
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());  // CLI11 wants it so
    try {
        app.parse(std::move(reversed));
    } catch (const CLI::Success& done) {
        app.exit(done, console.out, console.err);
        return tl::unexpected(ExitCode::ok);
    } catch (const CLI::ParseError& error) {
        return complain(console, complaint(app, arguments, error));
    }
    // The build prints the reference pages, wherever and for whomever it runs.
    const Command command = commandOf(app);
    if (command == Command::completions || command == Command::man) {
        parsed.invocation.command = command;
        return std::move(parsed.invocation);
    }
    if (!applied) return complain(console, describe(applied.error()));
    if (auto known = checkVariables(app); !known) return complain(console, describe(known.error()));
    return finish(app, parsed, *settings, console);
}

}  // namespace rivage::client
