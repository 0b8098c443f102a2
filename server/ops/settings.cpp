#include "server/ops/settings.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <map>

#include "server/ops/machine.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// A number and the unit behind it.
struct Quantity {
    double value = 0;
    std::string unit;
};

std::optional<Quantity> readQuantity(const std::string& text) {
    Quantity quantity;
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, quantity.value);
    if (error != std::errc() || !(quantity.value >= 0) || !std::isfinite(quantity.value))
        return std::nullopt;
    quantity.unit.assign(end, last);
    return quantity;
}

/// The flags, with the texts that are read in a second step.
class Flags {
public:
    explicit Flags(Settings& settings) : settings_(settings) {
        app_.set_config("--config", "", "file with settings, one `name=value` a line");
        app_.allow_config_extras(CLI::config_extras_mode::error);
        app_.set_version_flag("--version", std::string("rivage-server ") + RIVAGE_VERSION);
        app_.add_flag("--print-config", printConfig_, "print the settings in force and exit")
            ->configurable(false);
        addAddresses();
        addSizes();
        addTimes();
        addLog();
    }

    CLI::App& app() { return app_; }
    [[nodiscard]] bool printConfig() const { return printConfig_; }

private:
    /// A flag with the environment variable of the same name.
    template <typename T>
    CLI::Option* add(const std::string& name, T& value, const std::string& help) {
        std::string variable = "RIVAGE_" + name;
        for (char& c : variable) c = c == '-' ? '_' : static_cast<char>(std::toupper(c));
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
        add("connections", settings_.connections, "connections served at a time")
            ->check(CLI::Range(4, 4096));
    }

    void addSizes() {
        add("workers", settings_.workers, "jobs that run at a time")->check(CLI::Range(1, 1024));
        add("threads-per-job", settings_.threadsPerJob, "threads of one job")
            ->check(CLI::Range(1, 1024));
        add("queue-limit", settings_.queueLimit, "jobs that may wait beyond the workers")
            ->check(CLI::Range(0, 100000));
        addBytes("memory-budget", settings_.memoryBudget, 16 << 20,
                 "predicted memory of all running jobs together, e.g. 4GiB");
        addBytes("result-budget", settings_.resultBudget, 0,
                 "memory of all kept results together; the oldest are dropped");
        addBytes("max-upload", settings_.maxUpload, 1, "bytes of a grid, stored or inflated");
        add("max-voxels", settings_.maxVoxels, "voxels of a grid that are not empty")
            ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40));
        add("max-extent", settings_.maxExtent, "longest side of a grid, voxels")
            ->check(CLI::Range(1, 32768));
        add("max-models", settings_.maxModels, "models, and instances, of a scene")
            ->check(CLI::Range(1, 1000000));
        add("max-labels", settings_.maxLabels, "labels of a grid")->check(CLI::Range(1, 65535));
    }

    void addTimes() {
        addDuration("deadline", settings_.deadline, 1,
                    "longest time of a job, waiting included, e.g. 30s");
        addDuration("result-ttl", settings_.resultTtl, 1, "how long ended jobs are kept");
        addDuration("drain-timeout", settings_.drainTimeout, 0,
                    "how long running and waiting jobs may take after a stop signal");
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
    bool printConfig_ = false;
};

Settings machineDefaults() {
    Settings settings;
    settings.workers = usableProcessors();
    settings.queueLimit = std::max<std::size_t>(16, 4 * settings.workers);
    settings.memoryBudget = std::max<std::uint64_t>(256 << 20, usableMemory() / 4 * 3);
    settings.resultBudget = std::min<std::uint64_t>(1ULL << 30, settings.memoryBudget / 8);
    return settings;
}

}  // namespace

PoolSettings Settings::pool() const {
    PoolSettings pool;
    pool.workers = workers;
    pool.threadsPerJob = threadsPerJob;
    pool.queueLimit = queueLimit;
    pool.limits.maxInputBytes = maxUpload;
    pool.limits.maxVoxels = maxVoxels;
    pool.limits.maxExtent = maxExtent;
    pool.limits.maxModels = maxModels;
    pool.limits.maxLabels = maxLabels;
    pool.limits.maxMemory = memoryBudget / workers;
    pool.deadline = deadline;
    pool.store.resultTtl = resultTtl;
    pool.store.resultBytes = resultBudget;
    return pool;
}

proto::ServiceLimits Settings::limits() const {
    return {.conversion = pool().limits,
            .maxUploadBytes = maxUpload,
            .workers = workers,
            .queueLimit = queueLimit,
            .deadline = deadline,
            .resultTtl = resultTtl,
            .keptResultBytes = resultBudget};
}

core::Result<std::uint64_t> parseBytes(const std::string& text) {
    static const std::map<std::string, int> kShifts{{"", 0},   {"B", 0},    {"K", 10}, {"KiB", 10},
                                                    {"M", 20}, {"MiB", 20}, {"G", 30}, {"GiB", 30},
                                                    {"T", 40}, {"TiB", 40}};
    const auto quantity = readQuantity(text);
    const auto shift = quantity ? kShifts.find(quantity->unit) : kShifts.end();
    if (shift == kShifts.end())
        return fail(ErrorCode::invalidOption,
                    "\"" + text + "\" is no number of bytes such as 4096, 64MiB or 2G");
    const double bytes = std::ldexp(quantity->value, shift->second);
    if (bytes > 0x1p60) return fail(ErrorCode::invalidOption, "\"" + text + "\" is too much");
    return static_cast<std::uint64_t>(bytes);
}

core::Result<std::chrono::seconds> parseDuration(const std::string& text) {
    static const std::map<std::string, double> kSeconds{{"", 1},   {"ms", 0.001}, {"s", 1},
                                                        {"m", 60}, {"h", 3600},   {"d", 86400}};
    const auto quantity = readQuantity(text);
    const auto unit = quantity ? kSeconds.find(quantity->unit) : kSeconds.end();
    if (unit == kSeconds.end() || quantity->value > 1e9)
        return fail(ErrorCode::invalidOption,
                    "\"" + text + "\" is no duration such as 30s, 5m or 1h");
    return std::chrono::seconds(static_cast<long>(std::ceil(quantity->value * unit->second)));
}

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
    if (flags.printConfig()) {
        std::cout << flags.app().config_to_str(true);
        line.exitCode = 0;
    }
    return line;
}

}  // namespace rivage::server
