#include "server/http/metrics.h"

#include <unistd.h>

#include <fstream>
#include <sstream>

#include "proto/job.h"

namespace rivage::server {
namespace {

/// Writes the head of a metric, once for all its samples.
std::ostream& metric(std::ostream& out, const char* name, const char* type, const char* help) {
    return out << "# HELP " << name << ' ' << help << "\n# TYPE " << name << ' ' << type << '\n';
}

std::uint64_t residentBytes() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t total = 0;
    std::uint64_t resident = 0;
    file >> total >> resident;
    return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void writeJobs(std::ostream& out, const PoolStats& stats) {
    metric(out, "rivage_jobs_total", "counter", "Jobs that have ended, by outcome.");
    for (const proto::JobState state :
         {proto::JobState::succeeded, proto::JobState::failed, proto::JobState::canceled}) {
        std::uint64_t count = stats.jobs[static_cast<std::size_t>(state)];
        if (state == proto::JobState::failed) count -= stats.timedOut;
        out << "rivage_jobs_total{outcome=\"" << proto::stateName(state) << "\"} " << count << '\n';
    }
    out << "rivage_jobs_total{outcome=\"expired\"} " << stats.timedOut << '\n';

    metric(out, "rivage_admission_rejected_total", "counter", "Jobs not admitted, by reason.");
    out << "rivage_admission_rejected_total{reason=\"queue_full\"} " << stats.rejectedFull << '\n'
        << "rivage_admission_rejected_total{reason=\"draining\"} " << stats.rejectedDraining
        << '\n';
}

}  // namespace

std::string metricsText(const JobPool& pool) {
    const PoolStats stats = pool.stats();
    std::ostringstream out;
    writeJobs(out, stats);
    metric(out, "rivage_queue_depth", "gauge", "Jobs that wait for a worker.");
    out << "rivage_queue_depth " << stats.queued << '\n';
    metric(out, "rivage_queue_capacity", "gauge", "Jobs that may wait or be uploaded.");
    out << "rivage_queue_capacity " << pool.settings().queueLimit << '\n';
    metric(out, "rivage_workers", "gauge", "Workers.");
    out << "rivage_workers " << pool.settings().workers << '\n';
    metric(out, "rivage_workers_busy", "gauge", "Workers that run a job.");
    out << "rivage_workers_busy " << stats.running << '\n';
    metric(out, "process_resident_memory_bytes", "gauge", "Resident memory.");
    out << "process_resident_memory_bytes " << residentBytes() << '\n';
    metric(out, "rivage_build_info", "gauge", "Always 1; the labels say what runs.");
    out << "rivage_build_info{version=\"" << RIVAGE_VERSION << "\"} 1\n";
    return out.str();
}

}  // namespace rivage::server
