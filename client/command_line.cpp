#include "client/command_line.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "client/command_tree.h"
#include "client/complaint.h"
#include "client/printable.h"
#include "client/reference/joined.h"
#include "client/settings.h"
#include "proto/option_table.h"

namespace rivage::client {
namespace {

/// @param text  one line
tl::unexpected<ExitCode> complain(Console& console, const std::string& text) {
    console.err << "rivage: " << printable(text) << "\nRun with --help for more information.\n";
    return tl::unexpected(ExitCode::usage);
}

tl::unexpected<ExitCode> complain(Console& console, const Failure& failure) {
    return complain(console, describe(failure));
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

/// A result that is named is of the format that its name says. @return what is wrong, else empty
std::string takeFormatOfName(const std::string& out, Parsed& parsed) {
    std::error_code error;
    const auto& infos = proto::optionInfos();
    const auto info = std::find_if(infos.begin(), infos.end(),
                                   [](const auto& option) { return option.name == "output"; });
    std::string format = std::filesystem::path(out).extension().string();
    if (format.size() < 2 || out.ends_with('/') || parsed.invocation.inputs.size() > 1 ||
        (std::filesystem::exists(out, error) && !std::filesystem::is_regular_file(out, error)))
        return {};
    format.erase(0, 1);
    const bool known = std::count(info->words.begin(), info->words.end(), format) > 0;
    const auto given = parsed.options.find("output");
    if (given == parsed.options.end() && known) parsed.options["output"] = format;
    if (given == parsed.options.end() && !known)
        return out + ": no result is a ." + format + ", they are " + joined(info->words, ", ") +
               "; with --output any name will do";
    if (given != parsed.options.end() && known && given->second != format)
        return out + " is no name for --output " + given->second;
    return {};
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
    if (!key) return complain(console, key.error());
    invocation.apiKey = *std::move(key);
    if (!invocation.caFile.empty() && access(invocation.caFile.c_str(), R_OK) != 0)
        return complain(console, "--ca-file: cannot read " + invocation.caFile);
    if (invocation.command == Command::regularize)
        if (const std::string wrong = takeFormatOfName(invocation.out, parsed); !wrong.empty())
            return complain(console, wrong);
    invocation.options = optionsOf(invocation.command, parsed);
    auto valid = proto::parseOptions(invocation.options);
    if (!valid)
        return complain(console, valid.error().message + placeOf(valid.error(), parsed, settings));
    invocation.inForce = *std::move(valid);
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
        return tl::unexpected(outputArrived(console, "rivage") ? ExitCode::ok
                                                               : ExitCode::notWritten);
    } catch (const CLI::ParseError& error) {
        return complain(console, complaint(app, arguments, error));
    }
    // The build prints the reference pages, wherever and for whomever it runs.
    const Command command = commandOf(app);
    if (command == Command::completions || command == Command::man) {
        parsed.invocation.command = command;
        return std::move(parsed.invocation);
    }
    if (!applied) return complain(console, applied.error());
    if (auto known = checkVariables(app); !known) return complain(console, known.error());
    return finish(app, parsed, *settings, console);
}

}  // namespace rivage::client
