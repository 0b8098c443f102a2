#include "client/load/command_line.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <map>

#include "client/complaint.h"
#include "client/load/manual.h"
#include "client/printable.h"

namespace rivage::client::load {
namespace {

/// Longer runs are for who owns the server.
constexpr double kMaxSeconds = 3600;

/// A number in a range. CLI::Range lets NaN through, which is neither below nor above anything.
CLI::Validator within(double least, double most) {
    const CLI::Range range(least, most);
    return {[range](std::string& text) {
                double value = 0;
                const bool number = CLI::detail::lexical_cast(text, value) && std::isfinite(value);
                return number ? range(text) : text + " is no number";
            },
            range.get_description()};
}

void addServer(CLI::App& command, LoadOptions& options) {
    command.add_option("--server", options.server, "http[s]://HOST:PORT or unix:/PATH")
        ->envname("RIVAGE_SERVER")
        ->required()
        ->type_name("URL");
    command.add_option("--admin", options.admin, "Ask /metrics of this address each second")
        ->type_name("URL");
    command
        .add_option("--api-key-file", options.apiKeyFile,
                    "File whose first line is the API key; or set RIVAGE_API_KEY to the key")
        ->envname("RIVAGE_API_KEY_FILE")
        ->type_name("FILE");
    command
        .add_option("--ca-file", options.caFile,
                    "PEM file of certificates to trust, instead of those of the system")
        ->envname("RIVAGE_CA_FILE")
        ->type_name("FILE");
    command.add_flag("--i-own-this", options.ownThis,
                     "The server may be on another machine, and a run longer than 1 h");
}

void addWork(CLI::App& command, LoadOptions& options) {
    CLI::Option* mix = command.add_option("--mix", options.mix,
                                          "What to send (README) [the sample island, converted]");
    mix->type_name("FILE");
    command.add_option("--get", options.get, "Send GET requests for this path instead")
        ->type_name("PATH")
        ->excludes(mix);
    command.add_option("--verify", options.verify, "Share of the answers that is looked at")
        ->capture_default_str()
        ->check(within(0.0, 1.0));
    command.add_option("--warmup", options.warmup, "Seconds that are sent, but not counted")
        ->capture_default_str()
        ->check(within(0.0, kMaxSeconds));
    command.add_option("--out", options.out, "Write the report in all its forms to this folder")
        ->type_name("FOLDER");
    command.add_flag("--json", options.json, "Print JSON instead of the table");
    command.add_flag("-q,--quiet", options.quiet, "No live line");
}

void addGenerator(CLI::App& command, LoadOptions& options) {
    command.add_option("--threads", options.threads, "Threads that send")
        ->capture_default_str()
        ->check(CLI::Range(1, 256));
    command.add_option("--pin", options.pins, "Processors of the threads, such as 0,1")
        ->delimiter(',')
        ->check(CLI::Range(0, 1023))
        ->type_name("CPU");
    command.add_option("--connections", options.connections, "At most so many, for each thread")
        ->capture_default_str()
        ->check(CLI::Range(1, 100000));
    command.add_option("--timeout", options.timeout, "Seconds for an answer")
        ->capture_default_str()
        ->check(within(0.001, kMaxSeconds));
    command.add_flag("--no-keep-alive", options.noKeepAlive, "A new connection for each request");
    command.add_option("--seed", options.seed, "Of everything that is drawn")
        ->capture_default_str()
        ->check(CLI::NonNegativeNumber);
    command.add_option("--nice", options.nice, "Priority, as far as the user may")
        ->capture_default_str()
        ->check(CLI::Range(-20, 19));
    command.add_option("--max-requests", options.maxRequests, "The run ends after so many")
        ->capture_default_str()
        ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1'000'000'000}));
}

void addRun(CLI::App& app, LoadOptions& options) {
    CLI::App* run = app.add_subcommand("run", "Send a load and tell what came of it");
    addServer(*run, options);
    CLI::Option_group* loop = run->add_option_group("Load", "Exactly one of");
    loop->add_option("--rate", options.rate, "Open loop: requests a second")
        ->check(within(0.001, 1e6));
    loop->add_option("--concurrency", options.concurrency, "Closed loop: requests in flight")
        ->check(CLI::Range(1, 100000));
    loop->add_option("--replay", options.replay, "Open loop: a file of times (README)")
        ->type_name("FILE");
    loop->require_option(1);
    run->add_flag("--poisson", options.poisson, "Random times at this --rate, not even ones");
    run->add_option("--duration", options.duration, "Seconds that are counted")
        ->capture_default_str()
        ->check(within(0.1, 1e6));
    run->add_option("--slo", options.slo, "What the latency has to keep, such as p99=500ms")
        ->type_name("pN=TIME");
    addWork(*run, options);
    addGenerator(*run, options);
}

void addSearch(CLI::App& app, LoadOptions& options) {
    CLI::App* search =
        app.add_subcommand("search", "Find the highest rate that keeps a latency (the knee)");
    addServer(*search, options);
    search->add_option("--slo", options.slo, "What the latency has to keep [p99=500ms]")
        ->type_name("pN=TIME");
    search->add_option("--max-errors", options.maxErrors, "Share of errors, refusals included")
        ->capture_default_str()
        ->check(within(0.0, 1.0));
    search->add_option("--from", options.from, "First rate [a quarter of what a closed loop does]")
        ->check(within(0.001, 1e6));
    search->add_option("--precision", options.precision, "Of the knee, relative")
        ->capture_default_str()
        ->check(within(0.005, 1.0));
    search->add_option("--window", options.window, "Seconds; three of them have to agree")
        ->capture_default_str()
        ->check(within(1.0, 300.0));
    search->add_option("--curve", options.curve, "Measure these multiples of the knee at last")
        ->delimiter(',')
        ->check(within(0.01, 100.0));
    search->add_flag("--poisson", options.poisson, "Random times, not even ones");
    addWork(*search, options);
    addGenerator(*search, options);
}

void addOthers(CLI::App& app, LoadOptions& options) {
    CLI::App* selftest =
        app.add_subcommand("selftest", "Measure the generator itself, on a server of its own");
    selftest->add_flag("--short", options.selftest.brief, "A few seconds; speed is not judged");
    selftest->add_flag("!--no-wrk", options.selftest.wrk, "Do not compare with wrk");
    selftest->add_option("--rate", options.selftest.rate, "Requests a second that are asked for")
        ->capture_default_str()
        ->check(within(1.0, 1e6));
    selftest->add_option("--pin", options.selftest.pins, "Processor of the generator")
        ->check(CLI::Range(0, 1023))
        ->type_name("CPU");
    selftest->add_option("--nice", options.nice, "Priority, as far as the user may")
        ->capture_default_str()
        ->check(CLI::Range(-20, 19));

    CLI::App* stub =
        app.add_subcommand("stub", "A server that answers at once, to measure against");
    stub->add_option("--port", options.port, "On loopback [a free one]")
        ->check(CLI::Range(0, 65535));
    stub->add_option("--body", options.bodySize, "Bytes of an answer")
        ->capture_default_str()
        ->check(CLI::Range(0, 60000));
    stub->add_option("--work", options.workMicroseconds, "Microseconds of work for each answer")
        ->check(CLI::Range(0, 1'000'000));
    stub->add_option("--stall-at", options.stallAt, "Stand still so many seconds after the start")
        ->check(within(0.0, kMaxSeconds));
    stub->add_option("--stall-for", options.stallFor, "Seconds of standing still")
        ->check(within(0.0, kMaxSeconds));
}

tl::unexpected<LoadExit> complain(Console& console, const std::string& text) {
    console.err << "rivage-load: " << printable(text)
                << "\nRun with --help for more information.\n";
    return tl::unexpected(LoadExit::usage);
}

/// What is wrong between options, or null.
const char* contradiction(const LoadOptions& options) {
    if (options.command != LoadCommand::run) return nullptr;
    if (options.poisson && options.rate <= 0) return "--poisson needs --rate";
    if (options.duration > kMaxSeconds && !options.ownThis)
        return "a run of more than 3600 s needs --i-own-this";
    return nullptr;
}

}  // namespace

void describeLoadCommandLine(CLI::App& app, LoadOptions& options) {
    app.description("Measures how a rivage-server keeps up with a load.");
    app.footer(helpFooter());
    app.set_version_flag("--version", "rivage-load " RIVAGE_VERSION);
    app.require_subcommand(1);
    addRun(app, options);
    addSearch(app, options);
    addOthers(app, options);
    app.add_subcommand("man", "Print the man page");
    app.add_subcommand("completions", "Print the completions for a shell")
        ->add_option("SHELL", options.shell, "Which shell")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish"}));
}

tl::expected<LoadOptions, LoadExit> parseLoadCommandLine(const std::vector<std::string>& arguments,
                                                         Console& console) {
    CLI::App app("", "rivage-load");
    LoadOptions options;
    describeLoadCommandLine(app, options);
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());  // CLI11 wants it so
    try {
        app.parse(std::move(reversed));
    } catch (const CLI::Success& done) {
        app.exit(done, console.out, console.err);
        return tl::unexpected(outputArrived(console, "rivage-load") ? LoadExit::ok
                                                                    : LoadExit::notWritten);
    } catch (const CLI::ParseError& error) {
        return complain(console, complaint(app, arguments, error));
    }
    static const std::map<std::string, LoadCommand> kCommands{
        {"run", LoadCommand::run},           {"search", LoadCommand::search},
        {"selftest", LoadCommand::selftest}, {"stub", LoadCommand::stub},
        {"man", LoadCommand::man},           {"completions", LoadCommand::completions}};
    const CLI::App* command = app.get_subcommands().front();
    const std::string name = command->get_name();
    options.command = kCommands.at(name);
    if (name == "run" || name == "search") options.seedGiven = command->count("--seed") > 0;
    if (const char* wrong = contradiction(options)) return complain(console, wrong);
    options.typed = "rivage-load";
    for (const std::string& word : arguments) options.typed += " " + word;
    return options;
}

}  // namespace rivage::client::load
