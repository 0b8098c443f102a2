#include "server/ops/machine.h"

#include <malloc.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

namespace rivage::server {
namespace {

constexpr std::size_t kUnlimited = ~std::size_t{0};

/// The folders of this process in the cgroup hierarchy, most specific first. In a container the
/// root of the mount is usually the container's own group.
std::string ownGroup(const std::string& controller) {
    std::ifstream file("/proc/self/cgroup");
    for (std::string line; std::getline(file, line);) {
        const std::size_t first = line.find(':');
        const std::size_t second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string names = "," + line.substr(first + 1, second - first - 1) + ",";
        if (names == ",," ? controller.empty()
                          : names.find("," + controller + ",") != std::string::npos)
            return line.substr(second + 1);
    }
    return {};
}

/// The first word or words of a file in one's own group, or in the root group.
bool readGroupFile(const std::string& root, const std::string& group, const std::string& name,
                   std::string& first, std::string& second) {
    for (const std::string& folder : {root + group, root}) {
        std::ifstream file(folder + "/" + name);
        if (file >> first) {
            file >> second;
            return true;
        }
    }
    return false;
}

double quotaProcessors() {
    std::string quota;
    std::string period;
    const std::string root = "/sys/fs/cgroup";
    if (readGroupFile(root, ownGroup(""), "cpu.max", quota, period)) {
        if (quota == "max") return static_cast<double>(kUnlimited);
        return std::stod(quota) / std::stod(period);
    }
    std::string ignored;
    const std::string group = ownGroup("cpu");
    if (readGroupFile(root + "/cpu", group, "cpu.cfs_quota_us", quota, ignored) &&
        readGroupFile(root + "/cpu", group, "cpu.cfs_period_us", period, ignored) &&
        std::stod(quota) > 0)
        return std::stod(quota) / std::stod(period);
    return static_cast<double>(kUnlimited);
}

}  // namespace

std::size_t usableProcessors() {
    cpu_set_t set;
    CPU_ZERO(&set);
    std::size_t count = 1;
    if (::sched_getaffinity(0, sizeof set, &set) == 0)
        count = static_cast<std::size_t>(CPU_COUNT(&set));
    const double quota = std::max(1.0, std::ceil(quotaProcessors()));
    return quota < static_cast<double>(count) ? static_cast<std::size_t>(quota) : count;
}

std::uint64_t usableMemory() {
    const auto pages = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES));
    std::uint64_t bytes = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    std::string limit;
    std::string ignored;
    const std::string root = "/sys/fs/cgroup";
    const bool found = readGroupFile(root, ownGroup(""), "memory.max", limit, ignored) ||
                       readGroupFile(root + "/memory", ownGroup("memory"), "memory.limit_in_bytes",
                                     limit, ignored);
    if (found && limit != "max") bytes = std::min<std::uint64_t>(bytes, std::stoull(limit));
    return bytes;
}

void tuneMemory() {
    ::mallopt(M_ARENA_MAX, 1);
    ::mallopt(M_MMAP_THRESHOLD, 1 << 20);
    ::mallopt(M_TRIM_THRESHOLD, 1 << 20);
}

}  // namespace rivage::server
