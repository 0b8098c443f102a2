#include "client/command_tree.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <utility>

#include "client/job_calls.h"

namespace rivage::client {
namespace {

/// The ranges of CLI11 let NaN pass, which is not smaller than any bound.
CLI::Validator finite() {
    return {[](std::string& text) {
                double value = 0;
                return CLI::detail::lexical_cast(text, value) && std::isfinite(value)
                           ? std::string()
                           : "expected a number, not " + text;
            },
            ""};
}

std::string valueName(const proto::OptionInfo& info) {
    std::string text;
    for (const std::string& word : info.words) text += (text.empty() ? "" : "|") + word;
    switch (info.type) {
        case proto::OptionType::choice: return text;
        case proto::OptionType::flag: return "true|false";
        case proto::OptionType::dims:
        case proto::OptionType::spacing: return "XxYxZ";
        case proto::OptionType::weights: return "JSON";
        case proto::OptionType::ratio: return "N|N/M";
        case proto::OptionType::labels:
        case proto::OptionType::emboss: return text + "|JSON";
        case proto::OptionType::integer:
        case proto::OptionType::number: return text.empty() ? "NUMBER" : "NUMBER|" + text;
    }
    return text;
}

/// What each conversion option is if it is not given, nor set by a preset; empty: nothing.
std::map<std::string, std::string> defaultTexts() {
    std::map<std::string, std::string> texts;
    const proto::Json described = proto::describeOptions();
    for (const proto::Json& option : described["options"]) {
        const proto::Json& value = option["default"];
        texts[textOf(option, "name")] = value.is_string() ? value.get<std::string>()
                                        : value.is_null() ? std::string()
                                                          : proto::writeJson(value);
    }
    return texts;
}

/// One flag for every conversion option of the given groups; an empty list takes all.
void addConversionOptions(CLI::App& command, Parsed& parsed, const std::string& onlyGroup) {
    const std::map<std::string, std::string> normal = defaultTexts();
    for (const proto::OptionInfo& info : proto::optionInfos()) {
        if (!onlyGroup.empty() && info.group != onlyGroup) continue;
        command
            .add_option_function<std::string>(
                flagName(info.name),
                [&parsed, name = info.name](const std::string& value) {
                    parsed.options[name] = value;
                },
                info.sentence)
            ->default_str(normal.at(info.name))
            ->type_name(valueName(info))
            ->group("Conversion: " + info.group);
    }
}

void addCommon(CLI::App& app, Parsed& parsed) {
    app.add_option("--server", parsed.invocation.server,
                   "http[s]://HOST:PORT or unix:/PATH; without it a server is started for this run")
        ->envname("RIVAGE_SERVER")
        ->type_name("URL");
    app.add_option("--api-key-file", parsed.apiKeyFile,
                   "File whose first line is the API key; or set RIVAGE_API_KEY to the key")
        ->envname("RIVAGE_API_KEY_FILE")
        ->type_name("FILE");
    app.add_option("--ca-file", parsed.invocation.caFile,
                   "PEM file of certificates to trust, instead of those of the system")
        ->envname("RIVAGE_CA_FILE")
        ->type_name("FILE");
    app.add_option("--timeout", parsed.seconds, "Seconds for each input, waiting included")
        ->capture_default_str()
        ->check(finite())
        ->check(CLI::Range(0.001, 1e6))
        ->type_name("SECONDS");
    app.add_option("--config", parsed.configFile,
                   "File of settings, `name = value` a line [~/.config/rivage/config]")
        ->configurable(false)
        ->envname("RIVAGE_CONFIG")
        ->type_name("FILE");
    app.add_option("--color", parsed.invocation.color, "Colours: auto on a terminal")
        ->check(CLI::IsMember({"auto", "always", "never"}))
        ->capture_default_str()
        ->type_name("WHEN");
    app.add_flag("-q,--quiet", parsed.invocation.quiet, "Say nothing but errors");
    app.add_flag("--json", parsed.invocation.json, "Print JSON on stdout, one line for each input");
}

/// Every option that is configurable has a variable too. Those of the server begin with RIVAGE_
/// as well, so most of the client's have a beginning of their own.
void addVariables(CLI::App& app) {
    for (CLI::Option* option : app.get_options()) {
        if (!option->get_configurable() || option->get_positional() ||
            !option->get_envname().empty())
            continue;
        std::string variable = "RIVAGE_CLIENT_" + option->get_lnames().front();
        for (char& c : variable)
            c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        option->envname(variable);
    }
}

CLI::Option* addOut(CLI::App& command, Parsed& parsed, const std::string& sentence) {
    return command.add_option("-o,--out", parsed.invocation.out, sentence)
        ->configurable(false)
        ->type_name("PATH");
}

void addBatchOptions(CLI::App& command, Parsed& parsed) {
    command
        .add_option("-w,--workers", parsed.invocation.workers,
                    "Conversions at a time [2; the processors, if no server is named]")
        ->check(CLI::Range(1, 256))
        ->type_name("NUMBER");
    command.add_flag(
        "--if-newer", parsed.invocation.ifNewer,
        "Pass over inputs that are older than their results, made with the same options");
    command.add_flag("--stop-on-error", parsed.invocation.stopOnError,
                     "Begin no further conversion after the first that failed");
    command
        .add_flag("--watch", parsed.invocation.watch,
                  "Then wait, and convert again what changes, until Ctrl-C")
        ->configurable(false);
}

void addIds(CLI::App& command, Parsed& parsed) {
    command.add_option("ID", parsed.invocation.inputs, "Ids of jobs")
        ->required()
        ->check(CLI::Validator(
            [](const std::string& text) {
                return isJobId(text) ? std::string() : "no id of a job: " + text;
            },
            ""));
}

void addJobCommands(CLI::App& app, Parsed& parsed) {
    CLI::App* jobs = app.add_subcommand("jobs", "What a server works on, and has done");
    jobs->require_subcommand(1);
    CLI::App* list = jobs->add_subcommand("list", "Your jobs, newest first");
    list->add_option("--state", parsed.invocation.jobState, "Only those in this state")
        ->check(CLI::IsMember({"queued", "running", "succeeded", "failed", "canceled"}))
        ->type_name("STATE");
    list->add_option("--limit", parsed.invocation.jobLimit, "How many at most; 0 is all")
        ->capture_default_str()
        ->type_name("NUMBER");
    addIds(*jobs->add_subcommand("status", "How far jobs are"), parsed);
    addIds(*jobs->add_subcommand("wait", "Wait until jobs have ended"), parsed);
    addIds(*jobs->add_subcommand("cancel", "Cancel jobs that have not ended"), parsed);
    CLI::App* fetch = jobs->add_subcommand("fetch", "Wait for jobs and write their results");
    addIds(*fetch, parsed);
    addOut(*fetch, parsed, "A file, a folder, or '-' for stdout [ID.glb]");
}

/// Commands that need no server.
void addLocalCommands(CLI::App& app, Parsed& parsed) {
    CLI::App* compare = app.add_subcommand("compare", "Tell how two results differ");
    compare
        ->add_option("FILE", parsed.invocation.inputs,
                     "Two results, .glb or .obj, or two folders of them")
        ->required()
        ->expected(2)
        ->type_name("FILE");
    compare
        ->add_option("--max-distance", parsed.invocation.compare.maxDistance,
                     "End with 6 if surfaces are further apart, in voxels, or a file of a folder "
                     "has no partner")
        ->configurable(false)
        ->check(finite())
        ->check(CLI::NonNegativeNumber)
        ->type_name("NUMBER");
    compare
        ->add_option("--voxel-size", parsed.invocation.compare.voxelSize,
                     "Metres [what the reports in the files say]")
        ->configurable(false)
        ->check(finite())
        ->check(CLI::PositiveNumber)
        ->type_name("NUMBER");
    compare
        ->add_option("--samples", parsed.invocation.compare.samples,
                     "Points on each surface, beside all vertices")
        ->configurable(false)
        ->check(CLI::Range(0, 10'000'000))
        ->capture_default_str()
        ->type_name("NUMBER");
    CLI::App* completions = app.add_subcommand("completions", "Print a completion script");
    completions->footer(
        "Where a shell finds it for good:\n"
        "  bash  rivage completions bash > ~/.local/share/bash-completion/completions/rivage\n"
        "  zsh   rivage completions zsh > ~/.zfunc/_rivage   (fpath+=~/.zfunc before compinit)\n"
        "  fish  rivage completions fish > ~/.config/fish/completions/rivage.fish");
    completions->add_option("SHELL", parsed.invocation.inputs, "For which shell")
        ->required()
        ->expected(1)
        ->check(CLI::IsMember({"bash", "zsh", "fish"}));
    app.add_subcommand("man", "Print the man page")
        ->footer("To install it: rivage man > ~/.local/share/man/man1/rivage.1");
}

void addCommands(CLI::App& app, Parsed& parsed) {
    CLI::App* regularize =
        app.add_subcommand("regularize", "Convert voxel grids into smooth surfaces ('-' is stdin)");
    regularize
        ->add_option("IN", parsed.invocation.inputs,
                     "Grids (.vox, .npy, .nrrd, .nii, .vol, raw), folders of grids at any depth, "
                     "or patterns such as "
                     "'models/**/*.vox'")
        ->required();
    addOut(*regularize, parsed, "A file, a folder, or '-' for stdout [beside the input]");
    addBatchOptions(*regularize, parsed);
    addConversionOptions(*regularize, parsed, {});

    CLI::App* inspect = app.add_subcommand("inspect", "Tell what is in a grid");
    inspect->add_option("IN", parsed.invocation.inputs, "A grid, '-' is stdin")
        ->required()
        ->expected(1);
    addConversionOptions(*inspect, parsed, "input");

    CLI::App* sample = app.add_subcommand("sample", "Write a sample scene as .vox");
    CLI::Option* list =
        sample->add_flag("--list", parsed.list, "List the samples")->configurable(false);
    sample->add_option("NAME", parsed.invocation.inputs, "Which one")->expected(1)->excludes(list);
    addOut(*sample, parsed, "A file, or '-' for stdout [NAME.vox]")->excludes(list);

    addJobCommands(app, parsed);
    addLocalCommands(app, parsed);
    app.add_subcommand("options", "List the conversion options of the server, or explain one")
        ->add_option("NAME", parsed.invocation.inputs,
                     "An option; 'preset' lists the presets, the name of one tells what it sets")
        ->expected(1);
    app.add_subcommand("health", "Ask whether the server takes work");
}

}  // namespace

std::string flagName(std::string name) {
    std::replace(name.begin(), name.end(), '_', '-');
    return "--" + name;
}

Command commandOf(const CLI::App& app) {
    static const std::map<std::string, Command> kCommands{{"regularize", Command::regularize},
                                                          {"inspect", Command::inspect},
                                                          {"sample", Command::sample},
                                                          {"options", Command::options},
                                                          {"health", Command::health},
                                                          {"jobs list", Command::jobsList},
                                                          {"jobs status", Command::jobsStatus},
                                                          {"jobs wait", Command::jobsWait},
                                                          {"jobs cancel", Command::jobsCancel},
                                                          {"jobs fetch", Command::jobsFetch},
                                                          {"compare", Command::compare},
                                                          {"completions", Command::completions},
                                                          {"man", Command::man}};
    const CLI::App* command = app.get_subcommands().front();
    std::string name = command->get_name();
    if (!command->get_subcommands().empty())
        name += " " + command->get_subcommands().front()->get_name();
    return kCommands.at(name);
}

void describeCommandLine(CLI::App& app, Parsed& parsed) {
    app.set_version_flag("--version", "rivage " RIVAGE_VERSION)->configurable(false);
    app.require_subcommand(1);
    app.fallthrough();
    addCommon(app, parsed);
    addCommands(app, parsed);
    for (CLI::App* command : app.get_subcommands({})) addVariables(*command);
    addVariables(app);
}

}  // namespace rivage::client
