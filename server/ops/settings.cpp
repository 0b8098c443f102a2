#include "server/ops/settings.h"

#include <arpa/inet.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "proto/option_table.h"
#include "server/keys/api_keys.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// Variables of the client, of ./dev and of the build.
constexpr std::array<std::string_view, 12> kForeign{
    "RIVAGE_SERVER",      "RIVAGE_API_KEY", "RIVAGE_CACHE",        "RIVAGE_REFERENCE",
    "RIVAGE_HTTPLIB_DIR", "RIVAGE_BIN",     "RIVAGE_TESTS",        "RIVAGE_FUZZ",
    "RIVAGE_SANITIZE",    "RIVAGE_CONFIG",  "RIVAGE_API_KEY_FILE", "RIVAGE_CA_FILE"};

/// A service "rivage" or "rivage-x" gives every pod of its namespace RIVAGE_PORT,
/// RIVAGE_X_SERVICE_HOST, RIVAGE_PORT_80_TCP_ADDR and more.
bool comesFromKubernetes(std::string_view name) {
    return name.ends_with("_PORT") || name.find("_PORT_") != std::string_view::npos ||
           name.ends_with("_SERVICE_HOST");
}

core::Result<void> checkReadable(const char* flag, const std::string& path) {
    if (path.empty() || ::access(path.c_str(), R_OK) == 0) return {};
    return fail(ErrorCode::invalidOption, std::string(flag) + ": cannot read " + path);
}

core::Result<void> checkTls(const Settings& settings) {
    if (settings.tlsCert.empty() != settings.tlsKey.empty())
        return fail(ErrorCode::invalidOption, settings.tlsCert.empty()
                                                  ? "--tls-key needs --tls-cert"
                                                  : "--tls-cert needs --tls-key");
    if (auto cert = checkReadable("--tls-cert", settings.tlsCert); !cert) return cert;
    return checkReadable("--tls-key", settings.tlsKey);
}

/// Whether a folder is there, or could be made, and may be written to.
core::Result<void> checkFolder(const char* flag, const std::string& path) {
    namespace fs = std::filesystem;
    if (path.empty()) return {};
    std::error_code ignored;
    fs::path folder = fs::absolute(path, ignored);
    while (!fs::exists(folder, ignored) && folder.has_relative_path())
        folder = folder.parent_path();
    const bool usable =
        fs::is_directory(folder, ignored) && ::access(folder.c_str(), W_OK | X_OK) == 0;
    if (usable) return {};
    return fail(ErrorCode::invalidOption,
                std::string(flag) + ": cannot make or write the folder " + path);
}

}  // namespace

std::string proxyMistake(const std::string& text) {
    std::array<unsigned char, sizeof(in6_addr)> address{};
    const bool is = ::inet_pton(AF_INET, text.c_str(), address.data()) == 1 ||
                    ::inet_pton(AF_INET6, text.c_str(), address.data()) == 1;
    return is ? std::string() : "\"" + text + "\" is no IP address";
}

std::string originMistake(const std::string& text) {
    const std::size_t start = text.starts_with("https://")  ? 8
                              : text.starts_with("http://") ? 7
                                                            : std::string::npos;
    const auto allowed = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.' ||
               c == ':' || c == '[' || c == ']' || c == '_';
    };
    const bool is =
        start != std::string::npos && text.size() > start &&
        std::all_of(text.begin() + static_cast<std::ptrdiff_t>(start), text.end(), allowed);
    return is ? std::string()
              : "\"" + text +
                    "\" is no origin such as https://example.org: lower case, no path, no *";
}

std::string unknownVariable(const std::vector<std::string>& variables,
                            const std::vector<std::string>& known) {
    for (const std::string& name : variables) {
        const bool ours = name.starts_with("RIVAGE_") && !name.starts_with("RIVAGE_CLIENT_") &&
                          !comesFromKubernetes(name) &&
                          std::find(kForeign.begin(), kForeign.end(), name) == kForeign.end();
        if (!ours || std::find(known.begin(), known.end(), name) != known.end()) continue;
        const std::string near = proto::nearestName(name, known);
        return "the environment variable " + name + " is no setting" +
               (near.empty() ? std::string() : "; did you mean " + near + "?");
    }
    return {};
}

core::Result<void> checkSettings(const Settings& settings) {
    if (auto tls = checkTls(settings); !tls) return tls;
    if (auto folder = checkFolder("--state-dir", settings.stateDir); !folder) return folder;
    if (!settings.apiKeys.empty())
        if (const auto ring = KeyRing::load(settings.apiKeys); !ring)
            return fail(ErrorCode::invalidOption, "--api-keys: " + ring.error().message);
    if (settings.uploadBudget != 0 && settings.uploadBudget < settings.maxUpload)
        return fail(ErrorCode::invalidOption,
                    "--upload-budget is less than one upload of --max-upload bytes");
    return {};
}

std::uint64_t Settings::uploadBytes() const {
    if (uploadBudget != 0) return uploadBudget;
    const std::uint64_t most = memoryBudget / 8;
    const std::size_t places = workers + queueLimit;
    return std::max(2 * maxUpload, maxUpload < most / places ? places * maxUpload : most);
}

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
    pool.store.jobs = keptJobs;
    return pool;
}

proto::ServiceLimits Settings::limits() const {
    return {.conversion = pool().limits,
            .maxUploadBytes = maxUpload,
            .workers = workers,
            .queueLimit = queueLimit,
            .deadline = deadline,
            .resultTtl = resultTtl,
            .keptResultBytes = resultBudget,
            .keptJobs = keptJobs,
            .uploadBudget = uploadBytes(),
            .streams = streams,
            .longPolls = longPolls,
            .bodyTimeout = bodyTimeout,
            .minBodyRate = minBodyRate,
            .idleTimeout = idleTimeout};
}

}  // namespace rivage::server
