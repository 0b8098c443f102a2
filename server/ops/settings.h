#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "core/base/run_context.h"
#include "proto/job.h"
#include "server/net/address.h"
#include "server/jobs/job_pool.h"

namespace rivage::server {

enum class LogFormat : std::uint8_t { text, json };

/// Every setting of the server: flags, RIVAGE_ environment variables, a file; in this order.
struct Settings {
    std::string listen = "127.0.0.1:8080";
    std::string adminListen = "127.0.0.1:8081";  ///< or "off"
    std::size_t workers = 1;
    int threadsPerJob = 1;
    std::size_t queueLimit = 16;
    std::uint64_t memoryBudget = 0;  ///< bytes, of all running jobs together
    std::uint64_t resultBudget = 0;  ///< bytes, of all kept results together
    std::uint64_t maxUpload = 64ULL << 20;
    std::uint64_t maxVoxels = core::Limits().maxVoxels;
    std::uint64_t maxExtent = core::Limits().maxExtent;
    std::uint64_t maxModels = core::Limits().maxModels;
    std::uint64_t maxLabels = core::Limits().maxLabels;
    std::chrono::seconds deadline{120};
    std::chrono::seconds resultTtl{3600};
    std::chrono::seconds drainTimeout{30};
    std::size_t connections = 128;
    LogFormat logFormat = LogFormat::text;
    std::string logLevel = "info";

    [[nodiscard]] PoolSettings pool() const;
    [[nodiscard]] proto::ServiceLimits limits() const;
};

/// What the command line asks for.
struct CommandLine {
    Settings settings;
    std::optional<int> exitCode;  ///< set where the program has nothing to serve: --help and others
};

/// Reads flags, environment and file. Writes help, version, configuration and mistakes to stdout or
/// stderr. Unknown flags and keys, and values out of range, are mistakes.
CommandLine readCommandLine(int count, const char* const* arguments);

/// "64MiB", "1.5G", "4096" -> bytes. @errors invalidOption
core::Result<std::uint64_t> parseBytes(const std::string& text);

/// "30", "30s", "5m", "1h", "250ms" rounded up -> seconds. @errors invalidOption
core::Result<std::chrono::seconds> parseDuration(const std::string& text);

}  // namespace rivage::server
