#include "server/ops/metrics.h"

#include <prometheus/text_serializer.h>

#include <algorithm>
#include <array>

#include "server/ops/process_stats.h"

namespace rivage::server {
namespace {

using prometheus::Histogram;
using Buckets = Histogram::BucketBoundaries;

/// Those of the OpenTelemetry conventions, and three more for long conversions.
const Buckets kSeconds{0.005, 0.01, 0.025, 0.05, 0.075, 0.1, 0.25, 0.5, 0.75,
                       1,     2.5,  5,     7.5,  10,    30,  60,   120};
const Buckets kBytes{1 << 10, 1 << 14, 1 << 16, 1 << 18, 1 << 20,
                     1 << 22, 1 << 24, 1 << 26, 1 << 28};
const Buckets kCounts{1e2, 1e3, 1e4, 1e5, 3e5, 1e6, 3e6, 1e7, 1e8, 1e9};
const Buckets kIterations{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000};

prometheus::Family<Histogram>& family(prometheus::Registry& registry, const char* name,
                                      const char* help) {
    return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
}

std::string knownMethod(const std::string& method) {
    constexpr std::array<const char*, 9> kMethods{"GET",     "HEAD",  "POST",    "PUT",  "DELETE",
                                                  "OPTIONS", "PATCH", "CONNECT", "TRACE"};
    return std::find(kMethods.begin(), kMethods.end(), method) == kMethods.end() ? "_OTHER"
                                                                                 : method;
}

/// How a job ended, as `rivage_jobs_total` counts it.
std::string outcomeOf(const JobSnapshot& job) {
    if (job.view.state != proto::JobState::failed || !job.error)
        return proto::stateName(job.view.state);
    if (job.error->code == core::ErrorCode::timedOut) return "expired";
    return job.error->code == core::ErrorCode::poison ? "poison" : "failed";
}

double unixTime() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
}

}  // namespace

Metrics::Metrics()
    : requestSeconds_(family(registry_, "http_server_request_duration_seconds",
                             "Time from the head of a request to the end of its answer.")),
      requestBytes_(family(registry_, "http_server_request_body_size_bytes",
                           "Bodies of requests, as they were sent.")),
      responseBytes_(
          family(registry_, "http_server_response_body_size_bytes", "Bodies of answers.")),
      jobs_(prometheus::BuildCounter()
                .Name("rivage_jobs_total")
                .Help("Jobs that have ended or were not admitted, by outcome and problem.")
                .Register(registry_)),
      stageSeconds_(family(registry_, "rivage_job_stage_duration_seconds",
                           "Time that jobs have run, by stage.")),
      queueSeconds_(
          family(registry_, "rivage_job_queue_wait_seconds", "Time that jobs have waited.")
              .Add({}, kSeconds)),
      iterations_(family(registry_, "rivage_solver_iterations", "Iterations of the solver.")
                      .Add({}, kIterations)),
      voxels_(family(registry_, "rivage_input_voxels", "Voxels of grids that are not empty.")
                  .Add({}, kCounts)),
      triangles_(
          family(registry_, "rivage_output_triangles", "Triangles of results.").Add({}, kCounts)),
      outputBytes_(family(registry_, "rivage_output_bytes", "Bytes of results.").Add({}, kBytes)) {}

void Metrics::requestEnded(const RequestRecord& record) {
    const std::string method = knownMethod(record.method);
    requestSeconds_
        .Add({{"http_request_method", method},
              {"http_route", record.route},
              {"http_response_status_code", std::to_string(record.status)},
              {"error_type", record.problem}},
             kSeconds)
        .Observe(record.milliseconds / 1000);
    const Labels route{{"http_request_method", method}, {"http_route", record.route}};
    requestBytes_.Add(route, kBytes).Observe(static_cast<double>(record.bytesIn));
    responseBytes_.Add(route, kBytes).Observe(static_cast<double>(record.bytes));
}

void Metrics::jobEnded(const JobSnapshot& job) {
    const std::string reason =
        job.error ? std::string(proto::problemType(job.error->code).slug) : std::string();
    jobs_.Add({{"outcome", outcomeOf(job)}, {"reason", reason}}).Increment();
    queueSeconds_.Observe(job.times.queue / 1000);
    // What was run once is counted once, however many jobs it was for.
    if (!job.facts || job.reuse == Reuse::collapsed || job.reuse == Reuse::hit) return;
    for (std::size_t i = 0; i < core::kStageCount; ++i)
        if (job.times.stages[i] > 0)
            stageSeconds_.Add({{"stage", core::stageName(static_cast<core::Stage>(i))}}, kSeconds)
                .Observe(job.times.stages[i] / 1000);
    if (job.facts->voxels > 0) voxels_.Observe(static_cast<double>(job.facts->voxels));
    if (!job.result) return;
    outputBytes_.Observe(static_cast<double>(job.result->size()));
    iterations_.Observe(static_cast<double>(job.facts->iterations));
    triangles_.Observe(static_cast<double>(job.facts->triangles));
}

void Metrics::gauge(const char* name, const char* help, double value, const Labels& labels) {
    prometheus::BuildGauge().Name(name).Help(help).Register(registry_).Add(labels).Set(value);
}

/// Brings a counter up to a total that somebody else keeps.
void Metrics::count(const char* name, const char* help, double total, const Labels& labels) {
    prometheus::Counter& counter =
        prometheus::BuildCounter().Name(name).Help(help).Register(registry_).Add(labels);
    if (total > counter.Value()) counter.Increment(total - counter.Value());
}

void Metrics::readPool(const Service& service) {
    const PoolStats stats = service.pool.stats();
    const PoolSettings& settings = service.pool.settings();
    const double perJob = static_cast<double>(settings.limits.maxMemory);
    gauge("rivage_queue_depth", "Jobs that wait for a worker.", static_cast<double>(stats.queued));
    gauge("rivage_queue_capacity", "Jobs that may wait or be uploaded.",
          static_cast<double>(settings.queueLimit));
    gauge("rivage_workers", "Workers.", static_cast<double>(settings.workers));
    gauge("rivage_workers_busy", "Workers that run a job.", static_cast<double>(stats.running));
    gauge(
        "rivage_memory_reserved_bytes", "Memory that running jobs and uploads may take.",
        perJob * static_cast<double>(stats.running) + static_cast<double>(service.uploads.used()));
    gauge("rivage_memory_budget_bytes", "Memory that jobs may take together.",
          perJob * static_cast<double>(settings.workers));
    gauge("rivage_worker_heartbeat_timestamp_seconds", "When the workers last showed life.",
          unixTime() - std::chrono::duration<double>(stats.silence).count());

    for (const auto& [reason, total] : {std::pair{"queue_full", stats.rejectedFull},
                                        {"draining", stats.rejectedDraining},
                                        {"memory", service.uploads.refused()},
                                        {"quota", service.rejectedQuota.load()}}) {
        count("rivage_admission_rejected_total", "Requests not admitted, by reason.",
              static_cast<double>(total), {{"reason", reason}});
        count("rivage_jobs_total", "", static_cast<double>(total),
              {{"outcome", "rejected"}, {"reason", reason}});
    }
    for (const auto& [result, total] : {std::pair{"hit", stats.cacheHits},
                                        {"miss", stats.cacheMisses},
                                        {"coalesced", stats.coalesced}})
        count("rivage_cache_requests_total", "Requests for a result, by what the cache did.",
              static_cast<double>(total), {{"result", result}});
}

void Metrics::readConnections(const Service& service) {
    const auto active = service.net ? service.net->activeRequests.load() : 0;
    gauge("http_server_active_requests", "Requests whose answer is not written yet.",
          static_cast<double>(active));
    for (std::size_t i = 0; i < kPhaseNames.size(); ++i)
        gauge("http_server_open_connections", "Connections, by what they are at.",
              service.net ? static_cast<double>(service.net->count(static_cast<Phase>(i))) : 0,
              {{"state", std::string(kPhaseNames[i])}});
    count("rivage_restarts_total", "Restarts by the supervisor since it began.",
          static_cast<double>(service.restarts));
}

void Metrics::readProcess() {
    const ProcessStats stats = readProcessStats();
    count("process_cpu_seconds_total", "Processor time, user and system.", stats.cpuSeconds);
    gauge("process_start_time_seconds", "When the process began.", stats.startTimeSeconds);
    gauge("process_resident_memory_bytes", "Resident memory.", stats.residentBytes);
    gauge("process_virtual_memory_bytes", "Virtual memory.", stats.virtualBytes);
    gauge("process_open_fds", "Open file descriptors.", stats.openFiles);
    gauge("process_max_fds", "File descriptors that may be open.", stats.maxFiles);
    gauge("process_threads", "Threads.", stats.threads);
    gauge("rivage_build_info", "Always 1; the labels say what runs.", 1,
          {{"version", RIVAGE_VERSION},
           {"commit", RIVAGE_COMMIT},
           {"httplib", CPPHTTPLIB_VERSION},
           {"draco", RIVAGE_DRACO_VERSION}});
}

std::string Metrics::text(const Service& service) {
    const std::lock_guard lock(reading_);
    readPool(service);
    readConnections(service);
    readProcess();
    return prometheus::TextSerializer().Serialize(registry_.Collect());
}

}  // namespace rivage::server
