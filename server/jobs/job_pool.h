#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/pipeline.h"
#include "server/jobs/blob_store.h"
#include "server/jobs/crash_board.h"
#include "server/jobs/idempotency.h"
#include "server/jobs/job.h"
#include "server/jobs/job_index.h"
#include "server/jobs/job_queue.h"
#include "server/jobs/job_store.h"
#include "server/jobs/known_runs.h"
#include "server/jobs/task.h"
#include "server/jobs/uuid.h"

namespace rivage::server {

/// A conversion as the pool runs it; `core::convert` in production.
using Converter = std::function<core::Result<core::Artifact>(
    std::span<const std::byte> input, const core::ConversionOptions& options,
    const proto::Json& optionsEcho, const core::RunContext& run)>;

struct Engine {
    Converter convert;
    Converter inspect;          ///< its artifact is the JSON text of the inspection
    std::string version = "1";  ///< another version may give other bytes for the same grid
};

struct PoolSettings {
    std::size_t workers = 1;
    int threadsPerJob = 1;
    std::size_t queueLimit = 16;  ///< runs that wait or are being uploaded, beyond the workers
    core::Limits limits = {};
    std::chrono::milliseconds deadline{120000};  ///< default and maximum of `deadline_ms`
    std::chrono::milliseconds watchdog{
        0};  ///< deaf for so long after the deadline: stuck; 0: never
    StoreLimits store = {};
};

/// What outlives the process, where there is such a thing; each must outlive the pool.
struct Storage {
    BlobStore* blobs = nullptr;
    JobStore* jobs = nullptr;
    CrashBoard* crashes = nullptr;
};

/// What is to be done, as it was accepted.
struct JobRequest {
    JobKind kind = JobKind::convert;
    std::vector<std::byte> input = {};
    proto::JobOptions options = {};
    std::string name = "rivage";  ///< of the grid, without extension; safe in a header
    std::string owner = {};
    std::string idempotencyKey = {};
    std::string requestId = {};
    std::string traceparent = {};
    bool durable = false;  ///< the client gets its answer later
    bool fresh = false;    ///< the client wants no kept result
};

/// Counts since the start and the state now, for /metrics.
struct PoolStats {
    std::array<std::uint64_t, 5> jobs{};  ///< ended ones, by proto::JobState
    std::uint64_t timedOut = 0;           ///< of the failed ones
    std::uint64_t poisoned = 0;           ///< of the failed ones
    std::uint64_t rejectedFull = 0;
    std::uint64_t rejectedDraining = 0;
    std::uint64_t cacheHits = 0;
    std::uint64_t cacheMisses = 0;
    std::uint64_t coalesced = 0;
    std::size_t queued = 0;
    std::size_t running = 0;
    std::size_t unfinished = 0;            ///< jobs, also those that share a run
    std::chrono::milliseconds silence{0};  ///< of the worker that polled longest ago
};

/// A fixed number of workers behind a bounded queue.
///
/// Whoever wants to submit asks `admit` first, before anything is read from the network: the place
/// that the ticket stands for is then kept until the run ends or the ticket is dropped, so that
/// uploads, waiting and running runs together are bounded. Identical jobs share one run, and a
/// result that is still kept is not made again.
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
        JobPool* pool_;
    };

    /// Called once for every job that has ended, from the thread that ended it.
    using Observer = std::function<void(const JobFacts&, const JobSnapshot&)>;

    /// Takes over what an earlier process has left in `storage`: ended jobs can be found, others
    /// run again, but for those whose grid was running at two crashes.
    JobPool(const PoolSettings& settings, Engine engine, Observer observer = {},
            const Storage& storage = {});
    /// Stops what is left and joins the workers.
    ~JobPool();
    JobPool(const JobPool&) = delete;
    JobPool& operator=(const JobPool&) = delete;

    [[nodiscard]] const PoolSettings& settings() const { return settings_; }
    /// Whether the storage could be read. @errors those of `JobStore::load`
    [[nodiscard]] const core::Result<void>& recovered() const { return recovered_; }
    [[nodiscard]] IdempotencyKeys& idempotency() { return idempotency_; }

    /// Asks for a place. @errors busy; draining
    core::Result<Ticket> admit();
    /// Hands a job over. A durable one outlives the process from now on.
    /// @errors invalidOption if its deadline is above the server's; poison; storageFull; busy
    core::Result<std::shared_ptr<Job>> submit(Ticket ticket, JobRequest request);
    /// Makes a job that was not durable so. @errors storageFull; internal
    core::Result<void> keep(const std::shared_ptr<Job>& job);

    /// Of this owner only. @errors notFound; expired
    [[nodiscard]] core::Result<std::shared_ptr<Job>> find(const std::string& owner,
                                                          const std::string& id) const;
    [[nodiscard]] std::vector<std::shared_ptr<Job>> list(const JobQuery& query) const;
    /// The job with its place in the queue, its options and its report.
    [[nodiscard]] proto::JobView view(const Job& job) const;
    /// The bytes of a job that succeeded. @errors expired; internal if they are damaged
    core::Result<ResultPtr> result(Job& job);
    /// Stops a job that has not ended; it is then found as canceled.
    void cancel(const std::shared_ptr<Job>& job);
    /// Drops an ended job.
    void forget(const Job& job);
    /// Jobs of this owner that have not ended.
    [[nodiscard]] std::size_t unfinished(const std::string& owner) const;

    /// No job is admitted from now on.
    void beginDraining() { draining_ = true; }
    [[nodiscard]] bool draining() const { return draining_; }
    /// Nothing runs, waits or is being uploaded.
    [[nodiscard]] bool idle() const { return places_ == 0; }
    /// The end is near: durable jobs are left to the next process, all others are canceled, also
    /// those that are submitted from now on.
    void stopAll();

    /// When a place is likely to be free: an estimate from recent jobs, 1 to 60 s.
    [[nodiscard]] std::chrono::seconds retryAfter() const;
    [[nodiscard]] PoolStats stats() const;
    /// A worker has not listened for longer than the watchdog allows.
    [[nodiscard]] bool stuck() const { return stuck_; }

private:
    /// How often an input may have been running at a crash before it is refused.
    static constexpr int kPoisonous = 2;

    void release() { --places_; }
    /// Why an input is not run any more, or nothing.
    [[nodiscard]] std::optional<core::Error> quarantine(const std::string& hex) const;
    [[nodiscard]] BlobStore& blobs(bool durable);
    core::Result<JobFacts> describe(const JobRequest& request, const Blob& input);
    void attach(const std::shared_ptr<Job>& job, BlobPtr input, const proto::JobOptions& options,
                std::shared_ptr<void> place, bool fresh);
    core::Result<void> keepBytes(const Blob& blob);
    core::Result<void> save(const Job& job);

    core::Result<void> recover();
    void recover(const JobRecord& record);
    void work(std::size_t slot);
    core::Result<core::Artifact> run(Task& task);
    void settle(Task& task, core::Result<core::Artifact> artifact);
    RunOutcome outcomeOf(const Task& task, core::Result<core::Artifact> artifact);
    void conclude(const std::shared_ptr<Job>& job);
    void leave(const std::shared_ptr<Job>& job, const core::Error& reason);
    [[nodiscard]] std::vector<std::shared_ptr<Task>> tasks() const;
    [[nodiscard]] bool isLeftToNextProcess(const Job& job) const;

    void tidy();
    void expireJobs(Clock::time_point now);
    void tellPositions();
    void keepRecords();
    void collectBlobs(Clock::time_point now);
    void watch(Clock::time_point now);

    const PoolSettings settings_;
    const Engine engine_;
    const Observer observer_;
    MemoryBlobStore memory_;
    const Storage storage_;
    const std::unique_ptr<JobQueue> queue_;
    JobIndex index_;
    KnownRuns known_;
    IdempotencyKeys idempotency_;
    UuidSource uuids_;

    std::atomic<std::size_t> places_{0};  ///< taken: uploads, waiting and running runs
    std::atomic<bool> draining_{false};
    std::atomic<bool> stopping_{false};
    std::atomic<bool> stuck_{false};
    std::atomic<bool> superfluous_{false};  ///< there may be blobs that nobody needs
    Clock::time_point collected_;
    core::Result<void> recovered_;

    std::mutex saving_;         ///< held while a record is made and written
    mutable std::mutex mutex_;  ///< of what follows
    PoolStats stats_;
    struct Run {
        std::shared_ptr<Task> task;
        std::size_t slot;  ///< of its worker
    };
    std::vector<Run> running_;
    std::map<std::string, std::size_t> unfinished_;  ///< jobs, by owner
    std::vector<std::shared_ptr<Job>> unsaved_;      ///< ended, but the store had no room
    std::vector<const Task*> positions_;             ///< of the queue, as it was last told
    double meanSeconds_ = 1;                         ///< of recent jobs
    bool untrimmed_ = false;  ///< jobs have ended since memory was last given back
    bool closing_ = false;
    std::condition_variable close_;
    std::vector<std::thread> threads_;
};

}  // namespace rivage::server
