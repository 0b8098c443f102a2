#include "server/jobs/known_runs.h"

namespace rivage::server {

KnownRuns::Found KnownRuns::findOrAdd(const std::shared_ptr<Job>& job,
                                      const std::shared_ptr<Task>& task, bool fresh) {
    const std::string& key = task->key();
    const std::lock_guard lock(mutex_);
    if (!fresh && !key.empty()) {
        if (auto twin = finished(key)) return {std::move(twin), false};
        const auto run = runs_.find(key);
        const auto known = run == runs_.end() ? nullptr : run->second.lock();
        if (known && known->join(job)) return {nullptr, true};
    }
    (void)task->join(job);
    if (!key.empty()) runs_[key] = task;
    return {};
}

/// With the mutex held.
std::shared_ptr<Job> KnownRuns::finished(const std::string& key) const {
    const auto found = finished_.find(key);
    auto job = found == finished_.end() ? nullptr : found->second.lock();
    return job && job->snapshot().view.hasResult ? job : nullptr;
}

void KnownRuns::remember(const std::shared_ptr<Job>& job) {
    const std::lock_guard lock(mutex_);
    if (!job->facts().key.empty()) finished_[job->facts().key] = job;
}

void KnownRuns::forget(const Job& job) {
    const std::lock_guard lock(mutex_);
    const auto found = finished_.find(job.facts().key);
    if (found != finished_.end() && found->second.lock().get() == &job) finished_.erase(found);
}

void KnownRuns::sweep() {
    const std::lock_guard lock(mutex_);
    std::erase_if(runs_, [](const auto& item) { return item.second.expired(); });
    std::erase_if(finished_, [](const auto& item) { return item.second.expired(); });
}

}  // namespace rivage::server
