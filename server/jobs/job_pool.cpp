#include "server/jobs/job_pool.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rivage::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::fail;
using proto::JobState;

/// Everything that decides what a run gives, and who may see it, as one short text.
std::string runKey(const JobRequest& request, const Blob& input, const std::string& engine) {
    if (request.kind != JobKind::convert) return {};
    const std::string text = engine + '\n' + request.owner + '\n' + input.digest().hex + '\n' +
                             proto::writeJson(proto::toJson(request.options.conversion));
    return sha256(std::as_bytes(std::span(text))).hex;
}

Error full(std::string message, std::uint64_t limit, std::string setting) {
    Error error{ErrorCode::busy, std::move(message)};
    error.limit = limit;
    error.setting = std::move(setting);
    return error;
}

}  // namespace

JobPool::JobPool(const PoolSettings& settings, Engine engine, Observer observer,
                 const Storage& storage)
    : settings_(settings),
      engine_(std::move(engine)),
      observer_(std::move(observer)),
      storage_(storage),
      queue_(std::make_unique<LocalJobQueue>()),
      index_(settings.store) {
    recovered_ = recover();
    for (std::size_t i = 0; i < settings_.workers; ++i)
        threads_.emplace_back([this, i] { work(i); });
    threads_.emplace_back([this] { tidy(); });
}

JobPool::~JobPool() {
    beginDraining();
    stopAll();
    queue_->close();
    {
        const std::lock_guard lock(mutex_);
        closing_ = true;
    }
    close_.notify_all();
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
    return fail(
        full("all workers are busy and the queue is full", settings_.queueLimit, "--queue-limit"));
}

std::optional<Error> JobPool::quarantine(const std::string& hex) const {
    if (!storage_.crashes || storage_.crashes->crashes(hex) < kPoisonous) return std::nullopt;
    return Error{ErrorCode::poison,
                 "this grid was running when the server crashed, twice; it is not run again"};
}

/// Where bytes go: those of durable jobs into the store, if there is one.
BlobStore& JobPool::blobs(bool durable) {
    if (durable && storage_.blobs) return *storage_.blobs;
    return memory_;
}

core::Result<JobFacts> JobPool::describe(const JobRequest& request, const Blob& input) {
    const std::string& hex = input.digest().hex;
    if (auto error = quarantine(hex)) {
        error->field = "/grid";
        return fail(*std::move(error));
    }
    return JobFacts{.id = uuids_.next(std::chrono::system_clock::now()),
                    .kind = request.kind,
                    .owner = request.owner,
                    .idempotencyKey = request.idempotencyKey,
                    .key = runKey(request, input, engine_.version),
                    .options = proto::writeJson(proto::toJson(request.options)),
                    .progressive = request.options.run.progressive,
                    .name = request.name,
                    .requestId = request.requestId,
                    .traceparent = request.traceparent,
                    .inputSha256 = hex,
                    .inputBytes = input.bytes().size()};
}

core::Result<std::shared_ptr<Job>> JobPool::submit(Ticket ticket, JobRequest request) {
    const auto longest = static_cast<std::uint64_t>(settings_.deadline.count());
    const std::uint64_t asked = request.options.run.deadlineMs.value_or(longest);
    if (asked > longest)
        return fail(Error{ErrorCode::invalidOption, "deadline_ms is above the server's deadline",
                          "/options/deadline_ms", longest, asked, "--deadline"});
    // A durable job has its grid in the store before it is accepted.
    const auto input = blobs(request.durable).put(std::move(request.input));
    if (!input) return fail(input.error());
    auto facts = describe(request, **input);
    if (!facts) return fail(std::move(facts.error()));
    const auto deadline = Clock::now() + std::chrono::milliseconds(asked);
    const auto job = std::make_shared<Job>(*std::move(facts), deadline);
    {
        // Those that share a run need no place, so they have a bound of their own.
        const std::lock_guard lock(mutex_);
        if (stats_.unfinished >= std::max(settings_.store.jobs, settings_.workers))
            return fail(
                full("too many jobs have not ended yet", settings_.store.jobs, "--kept-jobs"));
        ++stats_.unfinished;
        ++unfinished_[request.owner];
    }
    if (job->facts().kind == JobKind::convert) index_.add(job);
    if (request.durable) {
        if (const auto kept = keep(job); !kept) {
            leave(job, kept.error());
            forget(*job);
            return fail(kept.error());
        }
    }
    attach(job, *input, request.options, std::make_shared<Ticket>(std::move(ticket)),
           request.fresh);
    return job;
}

/// Finds a twin for a job, or gives it a run of its own.
void JobPool::attach(const std::shared_ptr<Job>& job, BlobPtr input,
                     const proto::JobOptions& options, std::shared_ptr<void> place, bool fresh) {
    const bool suspect =
        storage_.crashes && storage_.crashes->crashes(job->facts().inputSha256) > 0;
    const auto task =
        std::make_shared<Task>(*job, std::move(input), options, std::move(place), suspect);
    const KnownRuns::Found found = known_.findOrAdd(job, task, fresh);
    std::uint64_t PoolStats::*count = &PoolStats::cacheMisses;
    if (found.finished) {
        if (const auto bytes = result(*found.finished)) {
            job->setReuse(Reuse::hit);
            (void)job->end({.result = *bytes, .facts = found.finished->snapshot().facts},
                           index_.resultTtl());
            conclude(job);
            count = &PoolStats::cacheHits;
        } else {
            return attach(job, task->input(), options, task->place(), true);
        }
    } else if (found.joined) {
        job->setReuse(Reuse::collapsed);
        count = &PoolStats::coalesced;
    } else {
        if (fresh) job->setReuse(Reuse::bypass);
        queue_->push(task);
    }
    const std::lock_guard lock(mutex_);
    if (!job->facts().key.empty()) ++(stats_.*count);
}

core::Result<void> JobPool::keep(const std::shared_ptr<Job>& job) {
    job->makeDurable();
    if (!storage_.jobs) return {};
    for (const auto& task : tasks())
        if (task->serves(*job))
            if (auto kept = keepBytes(*task->input()); !kept) return kept;
    return save(*job);
}

/// Copies bytes that are only in memory into the store.
core::Result<void> JobPool::keepBytes(const Blob& blob) {
    if (blob.durable()) return {};
    const auto bytes = blob.bytes();
    if (const auto kept = storage_.blobs->put({bytes.begin(), bytes.end()}); !kept)
        return fail(kept.error());
    return {};
}

core::Result<void> JobPool::save(const Job& job) {
    if (!storage_.jobs) return {};
    // An older state must not be written over a newer one.
    const std::lock_guard lock(saving_);
    const JobRecord record = job.record();
    if (const ResultPtr result = job.snapshot().result)
        if (auto kept = keepBytes(*result->blob); !kept) return kept;
    return storage_.jobs->save(record);
}

core::Result<std::shared_ptr<Job>> JobPool::find(const std::string& owner,
                                                 const std::string& id) const {
    return index_.find(owner, id);
}

std::vector<std::shared_ptr<Job>> JobPool::list(const JobQuery& query) const {
    return index_.list(query);
}

proto::JobView JobPool::view(const Job& job) const {
    proto::JobView view = job.view();
    if (view.state != JobState::queued) return view;
    const auto waiting = queue_->waiting();
    for (std::size_t i = 0; i < waiting.size(); ++i)
        if (waiting[i]->serves(job)) view.queuePosition = i;
    return view;
}

core::Result<ResultPtr> JobPool::result(Job& job) {
    const JobSnapshot snapshot = job.snapshot();
    if (snapshot.result) return snapshot.result;
    if (!snapshot.view.hasResult || !storage_.blobs)
        return fail(ErrorCode::expired, "the result of this job is no longer kept");
    const JobRecord record = job.record();
    auto blob = storage_.blobs->open(digestOf(record.resultSha256));
    if (!blob) {
        job.dropResult();
        return fail(std::move(blob.error()));
    }
    auto result =
        std::make_shared<const JobResult>(*std::move(blob), record.mediaType, record.extension);
    job.restoreResult(result);
    return result;
}

void JobPool::cancel(const std::shared_ptr<Job>& job) {
    leave(job, {ErrorCode::cancelled, "the job was canceled"});
}

/// Ends a job before its run has; a run that nobody wants any more stops, or never starts.
void JobPool::leave(const std::shared_ptr<Job>& job, const Error& reason) {
    if (!job->end({.error = reason}, index_.resultTtl())) return;
    for (const auto& task : tasks()) {
        task->leave(*job);
        if (!task->wanted()) queue_->remove(*task);
    }
    conclude(job);
}

void JobPool::forget(const Job& job) {
    known_.forget(job);
    index_.forget(job.id());
}

std::vector<std::shared_ptr<Task>> JobPool::tasks() const {
    auto tasks = queue_->waiting();
    const std::lock_guard lock(mutex_);
    for (const Run& run : running_) tasks.push_back(run.task);
    return tasks;
}

std::size_t JobPool::unfinished(const std::string& owner) const {
    const std::lock_guard lock(mutex_);
    const auto found = unfinished_.find(owner);
    return found == unfinished_.end() ? 0 : found->second;
}

bool JobPool::isLeftToNextProcess(const Job& job) const {
    return stopping_ && storage_.jobs && job.durable();
}

void JobPool::stopAll() {
    stopping_ = true;
    for (const auto& task : tasks()) {
        for (const auto& job : task->jobs())
            if (!isLeftToNextProcess(*job))
                leave(job, {ErrorCode::draining, "the server is stopping"});
        task->abandon();
        queue_->remove(*task);
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
    const auto now = Clock::now();
    const std::lock_guard lock(mutex_);
    PoolStats stats = stats_;
    stats.queued = queued;
    stats.running = running_.size();
    for (const auto& [task, slot] : running_)
        stats.silence =
            std::max(stats.silence,
                     std::chrono::duration_cast<std::chrono::milliseconds>(now - task->lastPoll()));
    return stats;
}

}  // namespace rivage::server
