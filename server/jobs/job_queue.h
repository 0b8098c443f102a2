#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "server/jobs/task.h"

namespace rivage::server {

/// Where runs wait for a worker. How many may wait is decided before, by `JobPool::admit`.
class JobQueue {
public:
    virtual ~JobQueue() = default;
    virtual void push(std::shared_ptr<Task> task) = 0;
    /// The next run; waits for one. Null when the queue is closed. Each is followed by `done`.
    /// A suspect is only given out while nothing else runs, and nothing beside it.
    virtual std::shared_ptr<Task> pop() = 0;
    virtual void done(const Task& task) = 0;
    /// Takes a run out that nobody wants any more. @return whether it was waiting
    virtual bool remove(const Task& task) = 0;
    /// All that wait, the next first.
    [[nodiscard]] virtual std::vector<std::shared_ptr<Task>> waiting() const = 0;
    virtual void close() = 0;
};

/// First come, first served, in memory.
class LocalJobQueue final : public JobQueue {
public:
    void push(std::shared_ptr<Task> task) override;
    std::shared_ptr<Task> pop() override;
    void done(const Task& task) override;
    bool remove(const Task& task) override;
    [[nodiscard]] std::vector<std::shared_ptr<Task>> waiting() const override;
    void close() override;

private:
    [[nodiscard]] bool mayStart() const;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::shared_ptr<Task>> tasks_;
    std::size_t running_ = 0;
    bool suspectRuns_ = false;
    bool closed_ = false;
};

}  // namespace rivage::server
