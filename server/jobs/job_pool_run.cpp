// What the pool's own threads do: take over, run, conclude, tidy up.
#include <malloc.h>

#include <algorithm>
#include <new>
#include <set>
#include <utility>

#include "server/jobs/job_pool.h"

namespace rivage::server {
namespace {

using core::Error;
using core::ErrorCode;
using core::fail;
using proto::JobState;

/// How often deadlines, places in the queue and times to live are looked at.
constexpr std::chrono::milliseconds kTidyInterval{50};
/// How often blobs that nobody needs are looked for, at most.
constexpr std::chrono::seconds kCollectInterval{1};

}  // namespace

/// Before any thread runs.
core::Result<void> JobPool::recover() {
    if (!storage_.jobs) return {};
    const auto records = storage_.jobs->load();
    if (!records) return fail(records.error());
    for (const JobRecord& record : *records) recover(record);
    keepRecords();
    superfluous_ = true;
    return {};
}

void JobPool::recover(const JobRecord& record) {
    const auto options = proto::parseOptions({}, record.options);
    // What was accepted gets its whole time again, however long nobody served.
    const auto time = static_cast<std::uint64_t>(settings_.deadline.count());
    const std::uint64_t asked = options ? options->run.deadlineMs.value_or(time) : time;
    const auto deadline = Clock::now() + std::chrono::milliseconds(std::min(asked, time));
    const auto job = std::make_shared<Job>(record, deadline);
    index_.add(job);
    idempotency_.remember(job);
    if (proto::hasEnded(record.state)) {
        index_.ended(job);
        if (record.state == JobState::succeeded) known_.remember(job);
        return;
    }
    {
        const std::lock_guard lock(mutex_);
        ++stats_.unfinished;
        ++unfinished_[record.owner];
    }
    auto input = storage_.blobs->open(digestOf(record.inputSha256));
    std::optional<Error> error = quarantine(record.inputSha256);
    if (!error && !options) error = options.error();
    if (!error && !input) error = Error{ErrorCode::internal, "the grid of this job was lost"};
    if (error) return leave(job, *error);
    ++places_;  // beyond the limit if need be: what was accepted is done
    attach(job, *std::move(input), *options, std::make_shared<Ticket>(this), false);
}

void JobPool::work(std::size_t slot) {
    while (const std::shared_ptr<Task> task = queue_->pop()) {
        {
            const std::lock_guard lock(mutex_);
            running_.push_back({task, slot});
        }
        if (stopping_) stopAll();
        if (task->start() && !task->stopRequested()) {
            for (const auto& job : task->jobs())
                if (job->durable()) (void)save(*job);
            if (storage_.crashes) storage_.crashes->begin(slot, task->input()->digest().hex);
            settle(*task, run(*task));
            if (storage_.crashes) storage_.crashes->end(slot);
        }
        {
            const std::lock_guard lock(mutex_);
            std::erase_if(running_, [&](const Run& run) { return run.slot == slot; });
        }
        queue_->done(*task);
    }
}

/// Runs the engine; whatever it throws stays here.
core::Result<core::Artifact> JobPool::run(Task& task) {
    core::RunContext context;
    context.threads = settings_.threadsPerJob;
    context.limits = settings_.limits;
    context.stopRequested = [&task] { return task.stopRequested(); };
    context.progress = [&task](core::Stage stage, double fraction) {
        task.report(stage, fraction);
    };
    context.energy = [&task](int step, double energy) { task.report({step, energy}); };
    if (task.options().run.progressive)
        context.preview = [this, &task](core::Preview preview) {
            if (auto blob = memory_.put(std::move(preview.bytes)))
                task.offer({preview.step, preview.energy,
                            std::make_shared<const JobResult>(
                                *std::move(blob), std::move(preview.mediaType), "glb")});
        };
    const core::ConversionOptions& options = task.options().conversion;
    const Converter& convert = task.kind() == JobKind::convert ? engine_.convert : engine_.inspect;
    try {
        return convert(task.input()->bytes(), options, proto::toJson(options), context);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::memoryBudget, "the server has not enough memory for this grid");
    } catch (const std::exception&) {
        return fail(ErrorCode::internal, "the conversion failed");
    }
}

/// The result goes where its jobs need it: into the store if one of them is durable.
RunOutcome JobPool::outcomeOf(const Task& task, core::Result<core::Artifact> artifact) {
    auto facts = std::make_shared<RunFacts>();
    facts->stages = task.stageTimes();
    if (!artifact) return {.error = std::move(artifact.error()), .facts = std::move(facts)};
    core::ConversionReport& report = artifact->report;
    facts->voxels = report.input.voxels;
    facts->surfels = report.surface.surfels;
    facts->triangles = report.output.triangles;
    facts->iterations = static_cast<std::uint64_t>(report.solve.iterations);
    report.milliseconds = facts->stages;
    report.output.bytes = artifact->bytes.size();
    if (task.kind() == JobKind::convert) facts->report = proto::writeJson(core::toJson(report));

    const auto jobs = task.jobs();
    const bool durable =
        std::any_of(jobs.begin(), jobs.end(), [](const auto& job) { return job->durable(); });
    auto blob = blobs(durable).put(std::move(artifact->bytes));
    if (!blob) {
        facts->report.clear();
        return {.error = std::move(blob.error()), .facts = std::move(facts)};
    }
    return {.result = std::make_shared<const JobResult>(
                *std::move(blob), std::move(artifact->mediaType), std::move(artifact->extension)),
            .facts = std::move(facts)};
}

void JobPool::settle(Task& task, core::Result<core::Artifact> artifact) {
    const RunOutcome outcome = outcomeOf(task, std::move(artifact));
    std::vector<std::shared_ptr<Job>> ended;
    known_.settle(task, [&](const std::shared_ptr<Job>& job) {
        if (task.stopRequested() && isLeftToNextProcess(*job)) return false;
        if (!job->end(outcome, index_.resultTtl())) return false;
        ended.push_back(job);
        return outcome.result != nullptr;
    });
    task.releasePlace();  // so that whoever has seen the end finds it free
    for (const auto& job : ended) conclude(job);
    if (ended.empty() || !outcome.result) return;
    double seconds = 0;
    for (const double stage : outcome.facts->stages) seconds += stage / 1000;
    const std::lock_guard lock(mutex_);
    meanSeconds_ += 0.2 * (seconds - meanSeconds_);
}

/// After a job has ended, however it did: keeps it for a while, counts it, tells the world.
void JobPool::conclude(const std::shared_ptr<Job>& job) {
    if (job->facts().kind == JobKind::convert) index_.ended(job);
    const bool saved = !job->durable() || save(*job).has_value();
    const JobSnapshot snapshot = job->snapshot();
    {
        const std::lock_guard lock(mutex_);
        if (!saved) unsaved_.push_back(job);
        ++stats_.jobs[static_cast<std::size_t>(snapshot.view.state)];
        if (snapshot.error && snapshot.error->code == ErrorCode::timedOut) ++stats_.timedOut;
        if (snapshot.error && snapshot.error->code == ErrorCode::poison) ++stats_.poisoned;
        --stats_.unfinished;
        const auto owner = unfinished_.find(job->facts().owner);
        if (--owner->second == 0) unfinished_.erase(owner);
        untrimmed_ = true;
    }
    superfluous_ = true;  // its grid
    if (observer_) observer_(job->facts(), snapshot);
    job->announce();
}

void JobPool::tidy() {
    std::unique_lock lock(mutex_);
    while (!close_.wait_for(lock, kTidyInterval, [&] { return closing_; })) {
        const bool trim = idle() && std::exchange(untrimmed_, false);
        lock.unlock();
        const auto now = Clock::now();
        expireJobs(now);
        tellPositions();
        index_.sweep(now);
        keepRecords();
        collectBlobs(now);
        known_.sweep();
        idempotency_.sweep();
        watch(now);
        if (trim) malloc_trim(0);
        lock.lock();
    }
}

void JobPool::expireJobs(Clock::time_point now) {
    for (const auto& task : tasks())
        for (const auto& job : task->jobs()) {
            if (now < job->deadline()) continue;
            const bool queued = job->state() == JobState::queued;
            leave(job, {ErrorCode::timedOut, queued ? "the deadline passed while the job was queued"
                                                    : "the deadline of this conversion passed"});
        }
}

/// Those who wait are told when their place in the queue has changed.
void JobPool::tellPositions() {
    const auto waiting = queue_->waiting();
    std::vector<const Task*> order(waiting.size());
    std::transform(waiting.begin(), waiting.end(), order.begin(),
                   [](const auto& task) { return task.get(); });
    if (order == positions_) return;
    for (std::size_t i = 0; i < waiting.size(); ++i) {
        if (i < positions_.size() && positions_[i] == order[i]) continue;
        for (const auto& job : waiting[i]->jobs()) job->advanceInQueue(i);
    }
    positions_ = std::move(order);
}

/// Brings the store up to what is in memory: what has gone, what has changed, what had no room.
void JobPool::keepRecords() {
    const JobIndex::Changes changes = index_.takeChanges();
    if (!storage_.jobs) return;
    std::vector<std::shared_ptr<Job>> unsaved;
    {
        const std::lock_guard lock(mutex_);
        unsaved.swap(unsaved_);
    }
    unsaved.insert(unsaved.end(), changes.changed.begin(), changes.changed.end());
    for (const auto& job : unsaved) {
        const bool forgotten = !index_.find(job->facts().owner, job->id());
        if (forgotten || !job->durable() || save(*job)) continue;
        const std::lock_guard lock(mutex_);
        unsaved_.push_back(job);
    }
    if (!changes.gone.empty()) (void)storage_.jobs->erase(changes.gone);
    if (!changes.gone.empty() || !changes.changed.empty()) superfluous_ = true;
}

/// Removes blobs that no job needs any more, now and then.
void JobPool::collectBlobs(Clock::time_point now) {
    if (!storage_.blobs || now - collected_ < kCollectInterval) return;
    if (!superfluous_.exchange(false)) return;
    collected_ = now;
    const std::set<std::string> needed = index_.needed();
    storage_.blobs->collect([&](const std::string& hex) { return needed.contains(hex); });
}

/// A worker that has not listened for long after the last deadline of its run will not come back.
void JobPool::watch(Clock::time_point now) {
    if (settings_.watchdog.count() == 0) return;
    const std::lock_guard lock(mutex_);
    for (const Run& run : running_) {
        if (run.task->abandonedFor(now) <= settings_.watchdog) continue;
        if (storage_.crashes) storage_.crashes->accuse(run.slot);
        stuck_ = true;
    }
}

}  // namespace rivage::server
