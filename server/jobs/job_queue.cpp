#include "server/jobs/job_queue.h"

#include <utility>

namespace rivage::server {

void LocalJobQueue::push(std::shared_ptr<Task> task) {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    changed_.notify_one();
}

/// With the mutex held.
bool LocalJobQueue::mayStart() const {
    if (tasks_.empty() || suspectRuns_) return false;
    return running_ == 0 || !tasks_.front()->suspect();
}

std::shared_ptr<Task> LocalJobQueue::pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || mayStart(); });
    if (closed_) return nullptr;
    std::shared_ptr<Task> task = std::move(tasks_.front());
    tasks_.pop_front();
    ++running_;
    suspectRuns_ = task->suspect();
    return task;
}

void LocalJobQueue::done(const Task& task) {
    const std::lock_guard lock(mutex_);
    --running_;
    if (task.suspect()) suspectRuns_ = false;
    changed_.notify_all();
}

bool LocalJobQueue::remove(const Task& task) {
    const std::lock_guard lock(mutex_);
    const auto removed =
        std::erase_if(tasks_, [&](const auto& other) { return other.get() == &task; });
    changed_.notify_all();
    return removed > 0;
}

std::vector<std::shared_ptr<Task>> LocalJobQueue::waiting() const {
    const std::lock_guard lock(mutex_);
    return {tasks_.begin(), tasks_.end()};
}

void LocalJobQueue::close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
}

}  // namespace rivage::server
