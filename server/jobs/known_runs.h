#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/jobs/task.h"

namespace rivage::server {

/// Runs by what they convert, so that the same is not done twice: those that go on, and the jobs
/// that still keep the result of one that is over. Safe to use from several threads.
class KnownRuns {
public:
    /// What was found for a job: a finished twin, or the run that it now belongs to.
    struct Found {
        std::shared_ptr<Job> finished = {};
        bool joined = false;
    };
    /// Looks for a twin of `job` and joins its run; else the job becomes the first of `task`.
    /// @param fresh  whether only `task` will do
    Found findOrAdd(const std::shared_ptr<Job>& job, const std::shared_ptr<Task>& task, bool fresh);

    /// A run is over. Until `finish` returns nobody can join it; then its result is found.
    /// @param finish  ends the jobs of the run
    template <typename Finish>
    void settle(Task& task, Finish finish) {
        const std::lock_guard lock(mutex_);
        std::shared_ptr<Job> keeper;
        for (const std::shared_ptr<Job>& job : task.seal())
            if (finish(job)) keeper = job;
        const auto run = runs_.find(task.key());
        if (run != runs_.end() && run->second.lock().get() == &task) runs_.erase(run);
        if (keeper && !task.key().empty()) finished_[task.key()] = keeper;
    }

    /// A job of an earlier process that succeeded.
    void remember(const std::shared_ptr<Job>& job);
    /// The result of this job is not to be used again.
    void forget(const Job& job);
    /// Forgets what is gone.
    void sweep();

private:
    [[nodiscard]] std::shared_ptr<Job> finished(const std::string& key) const;

    std::mutex mutex_;
    std::map<std::string, std::weak_ptr<Task>> runs_;
    std::map<std::string, std::weak_ptr<Job>> finished_;
};

}  // namespace rivage::server
