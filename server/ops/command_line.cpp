#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cassert>
#include <iostream>
#include <map>

#include "server/http/probe.h"
#include "server/keys/api_keys.h"
#include "server/ops/machine.h"
#include "server/ops/settings.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// The flags, with the texts that are read in a second step.
class Flags {
public:
    explicit Flags(Settings& settings) : settings_(settings) {
        app_.set_config("--config", "", "file with settings, one `name=value` a line");
        app_.allow_config_extras(CLI::config_extras_mode::error);
        app_.set_version_flag("--version", std::string("rivage-server ") + RIVAGE_VERSION);
        app_.add_flag("--print-config", printConfig_, "print the settings in force and exit")
            ->configurable(false);
        app_.add_flag("--hash-key{caller}", hashKey_,
                      "read a key from stdin, print its line for --api-keys, as --hash-key=NAME")
            ->configurable(false);
        app_.add_option("--probe", question_,
                        "ask the admin port of a running server whether it is live, ready or "
                        "started; the exit code is 0 if it is")
            ->check(CLI::IsMember({"live", "ready", "started"}))
            ->configurable(false);
        addAddresses();
        addAccess();
        addConnections();
        addSizes();
        addJobs();
        addLog();
    }

    CLI::App& app() { return app_; }
    [[nodiscard]] bool printConfig() const { return printConfig_; }

    [[nodiscard]] const std::string& hashKey() const { return hashKey_; }
    [[nodiscard]] const std::string& question() const { return question_; }

    /// After parsing: what could be stored only when all of it was there.
    void finish() {
        for (const auto& [name, list] : lists_)
            if (!texts_[name].empty()) *list = CLI::detail::split(texts_[name], ',');
    }

    /// The environment variables that are settings.
    [[nodiscard]] std::vector<std::string> variables() const {
        std::vector<std::string> names;
        for (const CLI::Option* option : app_.get_options())
            if (!option->get_envname().empty()) names.push_back(option->get_envname());
        return names;
    }

private:
    /// A flag with the environment variable of the same name.
    template <typename T>
    CLI::Option* add(const std::string& name, T& value, const std::string& help) {
        std::string variable = "RIVAGE_" + name;
        for (char& c : variable) c = c == '-' ? '_' : static_cast<char>(std::toupper(c));
        assert(!variable.ends_with("_PORT"));  // Kubernetes sets RIVAGE_PORT for its own purposes
        return app_.add_option("--" + name, value, help)->envname(variable)->capture_default_str();
    }

    /// A flag whose text is read by `parse`, which is told what is wrong with it.
    template <typename T, typename Parse>
    void addParsed(const std::string& name, T& value, std::string shown, const std::string& help,
                   Parse parse) {
        const auto read = [&value, parse](const std::string& text) -> std::string {
            const auto parsed = parse(text);
            if (!parsed) return parsed.error().message;
            value = *parsed;
            return {};
        };
        std::string& text = texts_[name] = std::move(shown);
        add(name, text, help)->check(CLI::Validator(read, ""));
    }

    void addBytes(const std::string& name, std::uint64_t& value, std::uint64_t least,
                  const std::string& help) {
        const auto parse = [least](const std::string& text) -> core::Result<std::uint64_t> {
            const auto bytes = parseBytes(text);
            if (bytes && *bytes < least)
                return fail(ErrorCode::invalidOption, "at least " + std::to_string(least));
            return bytes;
        };
        addParsed(name, value, std::to_string(value), help, parse);
    }

    void addDuration(const std::string& name, std::chrono::seconds& value, long least,
                     const std::string& help) {
        const auto parse = [least](const std::string& text) -> core::Result<std::chrono::seconds> {
            const auto duration = parseDuration(text);
            if (duration && (duration->count() < least || duration->count() > 30 * 86400))
                return fail(ErrorCode::invalidOption,
                            std::to_string(least) + "s to 30 days is allowed");
            return duration;
        };
        addParsed(name, value, std::to_string(value.count()) + "s", help, parse);
    }

    /// Several texts: the flag again, or commas between them.
    void addList(const std::string& name, std::vector<std::string>& value, const std::string& help,
                 std::string (*mistake)(const std::string&)) {
        const auto check = [mistake](const std::string& text) {
            for (const std::string& item : CLI::detail::split(text, ','))
                if (const std::string wrong = mistake(item); !text.empty() && !wrong.empty())
                    return wrong;
            return std::string();
        };
        lists_[name] = &value;
        add(name, texts_[name], help)->check(CLI::Validator(check, ""))->join(',');
    }

    void addSwitch(const std::string& name, bool& value, const std::string& help) {
        const auto parse = [](const std::string& text) -> core::Result<bool> {
            if (text == "true" || text == "false") return text == "true";
            return fail(ErrorCode::invalidOption, "true or false is allowed");
        };
        addParsed(name, value, value ? "true" : "false", help, parse);
    }

    void addAddresses() {
        const auto address = [](const std::string& text) -> std::string {
            const auto parsed = parseAddress(text);
            return parsed ? std::string() : parsed.error().message;
        };
        const auto admin = [address](const std::string& text) -> std::string {
            return text == "off" ? std::string() : address(text);
        };
        add("listen", settings_.listen, "host:port or unix:/path; port 0 takes a free one")
            ->check(CLI::Validator(address, ""));
        add("admin-listen", settings_.adminListen,
            "host:port of /livez, /readyz and /metrics, or off")
            ->check(CLI::Validator(admin, ""));
        addList("trusted-proxy", settings_.trustedProxies,
                "IP address of a proxy whose X-Forwarded-For is believed", proxyMistake);
    }

    void addAccess() {
        add("api-keys", settings_.apiKeys, "file of API keys; without it everybody may call");
        add("tls-cert", settings_.tlsCert, "PEM file of the certificate chain; turns TLS on");
        add("tls-key", settings_.tlsKey, "PEM file of the certificate's private key");
        addList("cors-origin", settings_.corsOrigins,
                "origin whose pages may call, such as https://example.org; off without it",
                originMistake);
    }

    void addConnections() {
        add("connections", settings_.connections, "connections open at a time")
            ->check(CLI::Range(4, 65536));
        add("streams", settings_.streams, "event streams open at a time")
            ->check(CLI::Range(0, 65536));
        add("long-polls", settings_.longPolls, "requests that wait for a job at a time")
            ->check(CLI::Range(0, 65536));
        addDuration("header-timeout", settings_.headerTimeout, 1, "longest time of a request head");
        addDuration("body-timeout", settings_.bodyTimeout, 1, "longest time of a request body");
        addBytes("min-body-rate", settings_.minBodyRate, 1,
                 "bytes per second that a body must come with, on average");
        addDuration("write-timeout", settings_.writeTimeout, 1,
                    "grace for a slow reader, who must then keep up with the same rate");
        addDuration("idle-timeout", settings_.idleTimeout, 1,
                    "how long a connection is kept between requests");
    }

    void addSizes() {
        addBytes("memory-budget", settings_.memoryBudget, 16 << 20,
                 "predicted memory of all running jobs together, e.g. 4GiB");
        addBytes("result-budget", settings_.resultBudget, 0,
                 "memory of all kept results together; the oldest are dropped");
        addBytes("max-upload", settings_.maxUpload, 1, "bytes of a grid, stored or inflated");
        addBytes("upload-budget", settings_.uploadBudget, 0,
                 "bytes of all uploads in flight together; 0 takes it from the other limits");
        add("max-voxels", settings_.maxVoxels, "voxels of a grid that are not empty")
            ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40));
        add("max-extent", settings_.maxExtent, "longest side of a grid, voxels")
            ->check(CLI::Range(1, 32768));
        add("max-models", settings_.maxModels, "models, and instances, of a scene")
            ->check(CLI::Range(1, 1000000));
        add("max-labels", settings_.maxLabels, "labels of a grid")->check(CLI::Range(1, 65535));
    }

    void addJobs() {
        add("workers", settings_.workers, "jobs that run at a time")->check(CLI::Range(1, 1024));
        add("threads-per-job", settings_.threadsPerJob, "threads of one job")
            ->check(CLI::Range(1, 1024));
        add("queue-limit", settings_.queueLimit, "jobs that may wait beyond the workers")
            ->check(CLI::Range(0, 100000));
        addDuration("deadline", settings_.deadline, 1,
                    "longest time of a job, waiting included, e.g. 30s");
        add("state-dir", settings_.stateDir,
            "folder in which jobs and results outlive the server; without it they do not");
        addDuration("result-ttl", settings_.resultTtl, 1, "how long ended jobs are kept");
        add("kept-jobs", settings_.keptJobs, "ended jobs that are kept; the oldest are dropped")
            ->check(CLI::Range(1, 1000000));
        addDuration("drain-delay", settings_.drainDelay, 0,
                    "how long to go on unready after a stop signal, until balancers have seen it");
        addDuration("drain-timeout", settings_.drainTimeout, 0,
                    "how long running and waiting jobs may take after a stop signal");
        addSwitch("supervise", settings_.supervise, "restart the server after a crash");
        addDuration("watchdog", settings_.watchdog, 1,
                    "how long a job may ignore its deadline before the server restarts");
        addDuration("quarantine-ttl", settings_.quarantineTtl, 1,
                    "how long a grid is refused that was running at two crashes");
    }

    void addLog() {
        const auto format = [](const std::string& text) -> core::Result<LogFormat> {
            if (text == "text") return LogFormat::text;
            if (text == "json") return LogFormat::json;
            return fail(ErrorCode::invalidOption, "text or json is allowed");
        };
        addParsed("log-format", settings_.logFormat, "text", "text or json", format);
        add("log-level", settings_.logLevel, "debug, info, warn, error or off")
            ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}));
    }

    Settings& settings_;
    CLI::App app_{"Rivage server: labelled voxel grids in, smooth surfaces out", "rivage-server"};
    std::map<std::string, std::string> texts_;
    std::map<std::string, std::vector<std::string>*> lists_;
    bool printConfig_ = false;
    std::string hashKey_;
    std::string question_;
};

Settings machineDefaults() {
    Settings settings;
    settings.workers = usableProcessors();
    settings.queueLimit = std::max<std::size_t>(16, 4 * settings.workers);
    settings.memoryBudget = std::max<std::uint64_t>(256 << 20, usableMemory() / 4 * 3);
    settings.resultBudget = std::min<std::uint64_t>(1ULL << 30, settings.memoryBudget / 8);
    return settings;
}

std::vector<std::string> environment() {
    std::vector<std::string> names;
    for (char** entry = ::environ; entry && *entry; ++entry) {
        const std::string_view text(*entry);
        names.emplace_back(text.substr(0, text.find('=')));
    }
    return names;
}

CommandLine refused(CommandLine line, const std::string& mistake) {
    std::cerr << mistake << "\nRun with --help for more information.\n";
    line.exitCode = 2;
    return line;
}

CommandLine hashKey(CommandLine line, const std::string& name) {
    std::string key;
    std::getline(std::cin, key);
    const auto text = keyLine(name, key);
    if (!text) return refused(std::move(line), text.error().message);
    std::cout << *text << '\n';
    line.exitCode = 0;
    return line;
}

/// Before the settings are checked as a whole: whoever asks need not be able to serve.
CommandLine answerProbe(CommandLine line, const std::string& question) {
    const auto asked = probe(line.settings.adminListen, question);
    if (!asked) std::cerr << asked.error().message << '\n';
    line.exitCode = asked ? 0 : 1;
    return line;
}

}  // namespace

CommandLine readCommandLine(int count, const char* const* arguments) {
    CommandLine line{machineDefaults(), std::nullopt};
    Flags flags(line.settings);
    try {
        flags.app().parse(count, arguments);
    } catch (const CLI::ParseError& error) {
        const int code = flags.app().exit(error, std::cout, std::cerr);
        line.exitCode = code == 0 ? 0 : 2;
        return line;
    }
    if (!flags.question().empty()) return answerProbe(std::move(line), flags.question());
    if (!flags.hashKey().empty()) return hashKey(std::move(line), flags.hashKey());
    flags.finish();
    if (const std::string mistake = unknownVariable(environment(), flags.variables());
        !mistake.empty())
        return refused(std::move(line), mistake);
    if (const auto checked = checkSettings(line.settings); !checked)
        return refused(std::move(line), checked.error().message);
    if (flags.printConfig()) {
        std::cout << flags.app().config_to_str(true);
        line.exitCode = 0;
    }
    return line;
}

}  // namespace rivage::server
