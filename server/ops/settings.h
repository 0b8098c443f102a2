#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/run_context.h"
#include "proto/job.h"
#include "server/jobs/job_pool.h"
#include "server/net/address.h"
#include "server/ops/units.h"

namespace rivage::server {

enum class LogFormat : std::uint8_t { text, json };

/// Every setting of the server: flags, RIVAGE_ environment variables, a file; in this order. No
/// setting is a secret: keys stand in files, and only the names of the files are here.
struct Settings {
    std::string listen = "127.0.0.1:8080";
    std::string adminListen = "127.0.0.1:8081";  ///< or "off"
    std::string tlsCert;                         ///< PEM files; both or neither
    std::string tlsKey;
    std::string apiKeys;                      ///< file of keys; empty: everybody may call
    std::vector<std::string> corsOrigins;     ///< exact origins; empty: CORS is off
    std::vector<std::string> trustedProxies;  ///< IP addresses whose X-Forwarded-For is believed

    std::size_t connections = 1024;
    std::size_t streams = 64;                ///< event streams at a time
    std::size_t longPolls = 64;              ///< waiting GETs at a time
    std::chrono::seconds headerTimeout{10};  ///< for a whole request head
    std::chrono::seconds bodyTimeout{300};   ///< for a whole body
    std::uint64_t minBodyRate = 1024;        ///< bytes per second, on average, after a grace time
    std::chrono::seconds writeTimeout{30};   ///< after it a reader must keep up with the rate
    std::chrono::seconds idleTimeout{65};    ///< between requests; above the 60 s of balancers

    std::size_t workers = 1;
    int threadsPerJob = 1;
    std::size_t queueLimit = 16;
    std::uint64_t memoryBudget = 0;  ///< bytes, of all running jobs together
    std::uint64_t resultBudget = 0;  ///< bytes, of all kept results together
    std::uint64_t maxUpload = 64ULL << 20;
    std::uint64_t uploadBudget = 0;  ///< bytes, of all uploads in flight; 0: `uploadBytes` decides
    std::uint64_t maxVoxels = core::Limits().maxVoxels;
    std::uint64_t maxExtent = core::Limits().maxExtent;
    std::uint64_t maxModels = core::Limits().maxModels;
    std::uint64_t maxLabels = core::Limits().maxLabels;
    std::chrono::seconds deadline{120};
    std::string stateDir;  ///< of durable jobs; empty: everything is kept in memory
    std::chrono::seconds resultTtl{24 * 3600};
    std::size_t keptJobs = 1000;  ///< ended jobs
    std::chrono::seconds drainDelay{0};
    std::chrono::seconds drainTimeout{30};
    bool supervise = true;              ///< a parent process restarts the server after a crash
    std::chrono::seconds watchdog{30};  ///< how long a job may ignore its deadline
    std::chrono::seconds quarantineTtl{7 * 86400};  ///< of inputs that crashed the server
    LogFormat logFormat = LogFormat::text;
    std::string logLevel = "info";

    /// Bytes of all uploads in flight together: as set, else enough for a full queue, but at most
    /// an eighth of the memory budget and at least two uploads of the largest size.
    [[nodiscard]] std::uint64_t uploadBytes() const;
    [[nodiscard]] PoolSettings pool() const;
    [[nodiscard]] proto::ServiceLimits limits() const;
};

/// What the command line asks for.
struct CommandLine {
    Settings settings;
    std::optional<int> exitCode;  ///< set where the program has nothing to serve: --help and others
};

/// Checks what one value alone does not show: files that go together, folders that can be made.
/// @errors invalidOption with a message that names the flag
core::Result<void> checkSettings(const Settings& settings);

/// What is wrong with the IP address of a proxy, or with an origin; empty if nothing is.
[[nodiscard]] std::string proxyMistake(const std::string& text);
[[nodiscard]] std::string originMistake(const std::string& text);

/// The names among `variables` that look like settings but are none: the message for the first, or
/// nothing. Names of the project's other programs, and those that Kubernetes makes for a service
/// called "rivage...", are left alone.
/// @param known  the variables that are settings
[[nodiscard]] std::string unknownVariable(const std::vector<std::string>& variables,
                                          const std::vector<std::string>& known);

/// Reads flags, environment and file. Writes help, version, configuration and mistakes to stdout or
/// stderr. Unknown flags, keys and RIVAGE_ variables, and values out of range, are mistakes.
CommandLine readCommandLine(int count, const char* const* arguments);

}  // namespace rivage::server
