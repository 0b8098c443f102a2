#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "server/jobs/job.h"

namespace rivage::server {

/// Where jobs wait for a worker. How many may wait is decided before, by `JobPool::admit`.
class JobQueue {
public:
    virtual ~JobQueue() = default;
    virtual void push(std::shared_ptr<Job> job) = 0;
    /// The next job; waits for one. Null when the queue is closed.
    virtual std::shared_ptr<Job> pop() = 0;
    /// Takes a job out that need not run any more.
    virtual void remove(const Job& job) = 0;
    /// How many jobs are before this one; none if it does not wait.
    [[nodiscard]] virtual std::optional<std::size_t> position(const Job& job) const = 0;
    /// All that wait, the next first.
    [[nodiscard]] virtual std::vector<std::shared_ptr<Job>> waiting() const = 0;
    virtual void close() = 0;
};

/// First come, first served, in memory.
class LocalJobQueue final : public JobQueue {
public:
    void push(std::shared_ptr<Job> job) override;
    std::shared_ptr<Job> pop() override;
    void remove(const Job& job) override;
    [[nodiscard]] std::optional<std::size_t> position(const Job& job) const override;
    [[nodiscard]] std::vector<std::shared_ptr<Job>> waiting() const override;
    void close() override;

private:
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::shared_ptr<Job>> jobs_;
    bool closed_ = false;
};

}  // namespace rivage::server
