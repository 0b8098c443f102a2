#include "server/jobs/job_queue.h"

#include <algorithm>
#include <utility>

namespace rivage::server {

void LocalJobQueue::push(std::shared_ptr<Job> job) {
    {
        const std::lock_guard lock(mutex_);
        jobs_.push_back(std::move(job));
    }
    changed_.notify_one();
}

std::shared_ptr<Job> LocalJobQueue::pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || !jobs_.empty(); });
    if (closed_) return nullptr;
    std::shared_ptr<Job> job = std::move(jobs_.front());
    jobs_.pop_front();
    return job;
}

void LocalJobQueue::remove(const Job& job) {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [&](const auto& other) { return other.get() == &job; });
}

std::optional<std::size_t> LocalJobQueue::position(const Job& job) const {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < jobs_.size(); ++i)
        if (jobs_[i].get() == &job) return i;
    return std::nullopt;
}

std::vector<std::shared_ptr<Job>> LocalJobQueue::waiting() const {
    const std::lock_guard lock(mutex_);
    return {jobs_.begin(), jobs_.end()};
}

void LocalJobQueue::close() {
    {
        const std::lock_guard lock(mutex_);
        closed_ = true;
    }
    changed_.notify_all();
}

}  // namespace rivage::server
