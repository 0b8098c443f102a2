#include "server/ops/process_stats.h"

#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace rivage::server {
namespace {

/// Fields of /proc/self/stat from the third on; the second, a name, may contain spaces.
std::vector<double> statFields() {
    std::ifstream file("/proc/self/stat");
    std::string text;
    std::getline(file, text);
    const std::size_t end = text.rfind(')');
    std::istringstream rest(end == std::string::npos ? std::string() : text.substr(end + 3));
    return {std::istream_iterator<double>(rest), std::istream_iterator<double>()};
}

double bootTime() {
    std::ifstream file("/proc/stat");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("btime ")) return std::stod(line.substr(6));
    return 0;
}

}  // namespace

ProcessStats readProcessStats() {
    ProcessStats stats;
    const double ticks = static_cast<double>(::sysconf(_SC_CLK_TCK));
    // proc(5): utime is field 14, stime 15, num_threads 20, starttime 22, vsize 23, rss 24; the
    // state, field 3, has been cut off.
    if (const std::vector<double> fields = statFields(); fields.size() > 20) {
        stats.cpuSeconds = (fields[10] + fields[11]) / ticks;
        stats.threads = fields[16];
        stats.startTimeSeconds = bootTime() + fields[18] / ticks;
        stats.virtualBytes = fields[19];
        stats.residentBytes = fields[20] * static_cast<double>(::sysconf(_SC_PAGESIZE));
    }
    std::error_code error;
    for (std::filesystem::directory_iterator file("/proc/self/fd", error), end;
         !error && file != end; file.increment(error))
        ++stats.openFiles;
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) == 0)
        stats.maxFiles = static_cast<double>(limit.rlim_cur);
    return stats;
}

}  // namespace rivage::server
