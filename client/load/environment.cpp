#include "client/load/environment.h"

#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <string_view>
#include <thread>

#include "client/load/taxonomy.h"
#include "client/transport.h"

namespace rivage::client::load {
namespace {

std::string firstLine(const char* path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

/// The value of a line "name : value" of a file below /proc.
std::string valueIn(const char* path, std::string_view name) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        const std::size_t colon = line.find(':');
        if (colon == std::string::npos || !line.starts_with(name)) continue;
        const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
        return begin == std::string::npos ? "" : line.substr(begin);
    }
    return {};
}

std::string orUnknown(const std::string& text) { return text.empty() ? "unknown" : text; }

std::string timeNow() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text;
}

}  // namespace

proto::Json describeEnvironment(const std::string& command) {
    utsname system{};
    uname(&system);
    const char* governor = "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";
    return {{"time", timeNow()},
            {"cpu", orUnknown(valueIn("/proc/cpuinfo", "model name"))},
            {"cores", std::thread::hardware_concurrency()},
            {"governor", orUnknown(firstLine(governor))},
            {"kernel", std::string(system.sysname) + " " + system.release},
            {"memory", orUnknown(valueIn("/proc/meminfo", "MemTotal"))},
            {"load_average", firstLine("/proc/loadavg")},
            {"nice", getpriority(PRIO_PROCESS, 0)},
            {"rivage_load", RIVAGE_VERSION},
            {"command", command}};
}

Outcome<proto::Json> serverVersion(const ServerAccess& server, Interrupt& interrupt) {
    Transport transport(server, interrupt, {.tries = 1});
    transport.setDeadline(Clock::now() + std::chrono::seconds(10));
    const auto answer = transport.send(makeRequest("GET", "/version"));
    if (!answer) {
        const bool absent = answer.error().exit == ExitCode::unreachable ||
                            answer.error().exit == ExitCode::cancelled;
        if (absent) return tl::unexpected(answer.error());
        return proto::Json();
    }
    return readAnswer(answer->body);
}

void prepareProcess(int nice) { setpriority(PRIO_PROCESS, 0, nice); }

Outcome<void> prepareFiles() {
    rlimit files{};
    if (getrlimit(RLIMIT_NOFILE, &files) == 0) {
        files.rlim_cur = files.rlim_max;
        setrlimit(RLIMIT_NOFILE, &files);
    }
    std::array<int, kFewestFiles> taken{};
    for (int& fd : taken) fd = eventfd(0, EFD_CLOEXEC);
    const int error = errno;
    const bool enough = taken.back() >= 0;
    for (const int fd : taken)
        if (fd >= 0) close(fd);
    if (enough) return {};
    return fail(ExitCode::failed, "Too few files can be opened: " + std::string(strerror(error)),
                "a process may have " + std::to_string(files.rlim_max) +
                    " open here, and even a small run needs " + std::to_string(kFewestFiles) +
                    " more than it was started with; raise the limit with ulimit -Hn");
}

}  // namespace rivage::client::load
