#include "server/jobs/job_pool.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

namespace rivage::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::fail;
using proto::JobState;

/// How often deadlines of waiting jobs and times to live are looked at.
constexpr std::chrono::milliseconds kTidyInterval{100};

}  // namespace

JobPool::JobPool(const PoolSettings& settings, Engine engine, Observer observer)
    : settings_(settings),
      engine_(std::move(engine)),
      observer_(std::move(observer)),
      queue_(std::make_unique<LocalJobQueue>()),
      index_(std::make_unique<JobIndex>(settings.store)) {
    for (std::size_t i = 0; i < settings_.workers; ++i) threads_.emplace_back([this] { work(); });
    threads_.emplace_back([this] { tidy(); });
}

JobPool::~JobPool() {
    beginDraining();
    cancelAll();
    queue_->close();
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    stop_.notify_all();
    for (std::thread& thread : threads_) thread.join();
}

core::Result<JobPool::Ticket> JobPool::admit() {
    if (draining_) {
        const std::lock_guard lock(mutex_);
        ++stats_.rejectedDraining;
        return fail(ErrorCode::draining, "the server is stopping and takes no new jobs");
    }
    const std::size_t places = settings_.workers + settings_.queueLimit;
    std::size_t taken = places_;
    while (taken < places && !places_.compare_exchange_weak(taken, taken + 1)) {
    }
    if (taken < places) return Ticket(this);

    const std::lock_guard lock(mutex_);
    ++stats_.rejectedFull;
    Error error{ErrorCode::busy, "all workers are busy and the queue is full"};
    error.limit = settings_.queueLimit;
    error.setting = "--queue-limit";
    return fail(std::move(error));
}

core::Result<std::shared_ptr<Job>> JobPool::submit(Ticket ticket, JobRequest request) {
    const auto longest = static_cast<std::uint64_t>(settings_.deadline.count());
    const std::uint64_t asked = request.options.run.deadlineMs.value_or(longest);
    if (asked > longest) {
        Error error{ErrorCode::invalidOption,
                    "deadline_ms is above the server's deadline",
                    "/options/deadline_ms",
                    longest,
                    asked,
                    "--deadline"};
        return fail(std::move(error));
    }
    const auto deadline = Clock::now() + std::chrono::milliseconds(asked);
    auto job = std::make_shared<Job>(uuids_.next(std::chrono::system_clock::now()),
                                     std::move(request), deadline);
    if (job->kind() == JobKind::convert) index_->add(job);
    ticket.pool_ = nullptr;  // the place now belongs to the job, until `conclude`
    queue_->push(job);
    return job;
}

core::Result<std::shared_ptr<Job>> JobPool::find(const std::string& id) const {
    return index_->find(id);
}

std::vector<std::shared_ptr<Job>> JobPool::list(const JobQuery& query) const {
    return index_->list(query);
}

proto::JobView JobPool::view(const Job& job) const {
    proto::JobView view = job.snapshot().view;
    if (view.state == JobState::queued) view.queuePosition = queue_->position(job);
    return view;
}

void JobPool::cancel(const std::shared_ptr<Job>& job) {
    if (!job->cancel()) return;
    queue_->remove(*job);
    conclude(job);
}

void JobPool::cancelAll() {
    cancelling_ = true;  // for a job between the queue and `running_`
    for (const auto& job : queue_->waiting()) cancel(job);
    std::vector<std::shared_ptr<Job>> running;
    {
        const std::lock_guard lock(mutex_);
        running = running_;
    }
    for (const auto& job : running) cancel(job);
}

void JobPool::work() {
    while (const std::shared_ptr<Job> job = queue_->pop()) {
        {
            const std::lock_guard lock(mutex_);
            running_.push_back(job);
        }
        const bool ended = cancelling_ ? job->cancel() : job->expire(Clock::now());
        const bool started = !ended && job->start();
        if (started) job->finish(run(*job));
        {
            const std::lock_guard lock(mutex_);
            std::erase(running_, job);
        }
        if (ended || started) conclude(job);
    }
}

/// Runs the engine; whatever it throws stays here.
core::Result<core::Artifact> JobPool::run(Job& job) {
    core::RunContext context;
    context.threads = settings_.threadsPerJob;
    context.limits = settings_.limits;
    context.stopRequested = [&job] { return job.stopRequested(); };
    context.stopReason = [&job] { return job.stopReason(); };
    context.progress = [&job](core::Stage stage, double fraction) { job.report(stage, fraction); };
    const core::ConversionOptions& options = job.options().conversion;
    const Converter& convert = job.kind() == JobKind::convert ? engine_.convert : engine_.inspect;
    try {
        return convert(job.input(), options, proto::toJson(options), context);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::memoryBudget, "the server has not enough memory for this grid");
    } catch (const std::exception&) {
        return fail(ErrorCode::internal, "the conversion failed");
    }
}

/// After a job has ended, however it did: counts it, keeps it for a while, frees its place.
void JobPool::conclude(const std::shared_ptr<Job>& job) {
    if (job->kind() == JobKind::convert) index_->ended(job);
    const JobSnapshot snapshot = job->snapshot();
    double seconds = 0;
    {
        const std::lock_guard lock(mutex_);
        ++stats_.jobs[static_cast<std::size_t>(snapshot.view.state)];
        if (snapshot.error && snapshot.error->code == ErrorCode::timedOut) ++stats_.timedOut;
        stats_.queueSeconds += snapshot.times.queue / 1000;
        for (std::size_t i = 0; i < core::kStageCount; ++i) {
            stats_.stageSeconds[i] += snapshot.times.stages[i] / 1000;
            seconds += snapshot.times.stages[i] / 1000;
        }
        if (snapshot.view.state == JobState::succeeded)
            meanSeconds_ += 0.2 * (seconds - meanSeconds_);
        untrimmed_ = true;
    }
    if (observer_) observer_(snapshot);
    release();
    job->announce();
}

void JobPool::tidy() {
    std::unique_lock lock(mutex_);
    while (!stop_.wait_for(lock, kTidyInterval, [&] { return stopping_; })) {
        const bool trim = idle() && std::exchange(untrimmed_, false);
        lock.unlock();
        for (const auto& job : queue_->waiting()) {
            if (!job->expire(Clock::now())) continue;
            queue_->remove(*job);
            conclude(job);
        }
        index_->sweep(Clock::now());
        if (trim) malloc_trim(0);
        lock.lock();
    }
}

std::chrono::seconds JobPool::retryAfter() const {
    const double ahead = static_cast<double>(places_) / static_cast<double>(settings_.workers);
    const std::lock_guard lock(mutex_);
    const double seconds = std::ceil(meanSeconds_ * ahead / 2);
    return std::chrono::seconds(static_cast<long>(std::clamp(seconds, 1.0, 60.0)));
}

PoolStats JobPool::stats() const {
    const std::size_t queued = queue_->waiting().size();
    const std::lock_guard lock(mutex_);
    PoolStats stats = stats_;
    stats.queued = queued;
    stats.running = running_.size();
    return stats;
}

}  // namespace rivage::server
