#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/pipeline.h"
#include "server/jobs/job.h"
#include "server/jobs/job_index.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/uuid.h"

namespace rivage::server {

/// A conversion as the pool runs it; `core::convert` in production.
using Converter = std::function<core::Result<core::Artifact>(
    std::span<const std::byte> input, const core::ConversionOptions& options,
    const proto::Json& optionsEcho, const core::RunContext& run)>;

struct Engine {
    Converter convert;
    Converter inspect;  ///< its artifact is the JSON text of the inspection
};

struct PoolSettings {
    std::size_t workers = 1;
    int threadsPerJob = 1;
    std::size_t queueLimit = 16;  ///< jobs that wait or are being uploaded, beyond the workers
    core::Limits limits = {};
    std::chrono::milliseconds deadline{120000};  ///< default and maximum of `deadline_ms`
    StoreLimits store = {};
};

/// Counts since the start and the state now, for /metrics.
struct PoolStats {
    std::array<std::uint64_t, 5> jobs{};  ///< ended ones, by proto::JobState
    std::uint64_t timedOut = 0;           ///< of the failed ones
    std::uint64_t rejectedFull = 0;
    std::uint64_t rejectedDraining = 0;
    std::size_t queued = 0;
    std::size_t running = 0;
    double queueSeconds = 0;
    std::array<double, core::kStageCount> stageSeconds{};
};

/// A fixed number of workers behind a bounded queue.
///
/// Whoever wants to submit asks `admit` first, before anything is read from the network: the place
/// that the ticket stands for is then kept until the job ends or the ticket is dropped, so that
/// uploads, waiting jobs and running jobs together are bounded.
class JobPool {
public:
    class Ticket {
    public:
        explicit Ticket(JobPool* pool) : pool_(pool) {}
        Ticket(Ticket&& other) noexcept : pool_(std::exchange(other.pool_, nullptr)) {}
        Ticket& operator=(Ticket&&) = delete;
        ~Ticket() {
            if (pool_) pool_->release();
        }

    private:
        friend class JobPool;
        JobPool* pool_;
    };

    /// Called once for every job that has ended, from the thread that ended it.
    using Observer = std::function<void(const JobSnapshot&)>;

    JobPool(const PoolSettings& settings, Engine engine, Observer observer = {});
    /// Cancels what is left and joins the workers.
    ~JobPool();
    JobPool(const JobPool&) = delete;
    JobPool& operator=(const JobPool&) = delete;

    [[nodiscard]] const PoolSettings& settings() const { return settings_; }

    /// Asks for a place. @errors busy; draining
    core::Result<Ticket> admit();
    /// Hands a job over. @errors invalidOption if its deadline is above the server's
    core::Result<std::shared_ptr<Job>> submit(Ticket ticket, JobRequest request);

    /// @errors notFound; expired
    [[nodiscard]] core::Result<std::shared_ptr<Job>> find(const std::string& id) const;
    [[nodiscard]] std::vector<std::shared_ptr<Job>> list(const JobQuery& query) const;
    /// The job with its place in the queue.
    [[nodiscard]] proto::JobView view(const Job& job) const;
    /// Stops a job that has not ended; it is then found as canceled.
    void cancel(const std::shared_ptr<Job>& job);
    /// Drops an ended job.
    void forget(const Job& job) { index_->forget(job.id()); }

    /// No job is admitted from now on.
    void beginDraining() { draining_ = true; }
    [[nodiscard]] bool draining() const { return draining_; }
    /// Nothing runs, waits or is being uploaded.
    [[nodiscard]] bool idle() const { return places_ == 0; }
    /// Cancels every job, also those that are submitted from now on: the end is near.
    void cancelAll();

    /// When a place is likely to be free: an estimate from recent jobs, 1 to 60 s.
    [[nodiscard]] std::chrono::seconds retryAfter() const;
    [[nodiscard]] PoolStats stats() const;

private:
    void release() { --places_; }
    void work();
    void tidy();
    core::Result<core::Artifact> run(Job& job);
    void conclude(const std::shared_ptr<Job>& job);

    const PoolSettings settings_;
    const Engine engine_;
    const Observer observer_;
    std::unique_ptr<JobQueue> queue_;
    std::unique_ptr<JobIndex> index_;
    UuidSource uuids_;

    std::atomic<std::size_t> places_{0};  ///< taken: uploads, waiting and running jobs
    std::atomic<bool> draining_{false};
    std::atomic<bool> cancelling_{false};

    mutable std::mutex mutex_;  ///< of what follows
    PoolStats stats_;
    std::vector<std::shared_ptr<Job>> running_;
    double meanSeconds_ = 1;  ///< of recent jobs
    bool untrimmed_ = false;  ///< jobs have ended since memory was last given back
    bool stopping_ = false;
    std::condition_variable stop_;
    std::vector<std::thread> threads_;
};

}  // namespace rivage::server
