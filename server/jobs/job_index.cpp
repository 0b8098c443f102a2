#include "server/jobs/job_index.h"

#include <algorithm>
#include <utility>

namespace rivage::server {
namespace {

using core::ErrorCode;

/// Ids remembered to answer "expired" instead of "not found"; about 100 bytes each.
constexpr std::size_t kRemembered = 65536;

}  // namespace

void JobIndex::add(std::shared_ptr<Job> job) {
    const std::lock_guard lock(mutex_);
    jobs_.emplace(job->id(), std::move(job));
}

core::Result<std::shared_ptr<Job>> JobIndex::find(const std::string& id) const {
    const std::lock_guard lock(mutex_);
    if (const auto found = jobs_.find(id); found != jobs_.end()) return found->second;
    if (expired_.contains(id)) return core::fail(ErrorCode::expired, "this job has expired", "/id");
    return core::fail(ErrorCode::notFound, "there is no job with this id", "/id");
}

std::vector<std::shared_ptr<Job>> JobIndex::list(const JobQuery& query) const {
    std::vector<std::shared_ptr<Job>> list;
    const std::lock_guard lock(mutex_);
    auto end = query.after.empty() ? jobs_.end() : jobs_.lower_bound(query.after);
    while (end != jobs_.begin() && list.size() < query.limit) {
        --end;
        if (!query.state || end->second->state() == *query.state) list.push_back(end->second);
    }
    return list;
}

void JobIndex::ended(const std::shared_ptr<Job>& job) {
    const auto result = job->snapshot().result;
    const std::uint64_t bytes = result ? result->bytes.size() : 0;
    job->setExpiry(std::chrono::system_clock::now() + limits_.resultTtl);

    const std::lock_guard lock(mutex_);
    if (!jobs_.contains(job->id())) return;  // forgotten while it ran
    ended_.push_back({job, Clock::now() + limits_.resultTtl, bytes});
    keptBytes_ += bytes;
    dropOldestResults();
    while (ended_.size() > limits_.jobs) expireOldest();
}

/// The newest result is kept even if it alone fills the room: its client waits for it.
void JobIndex::dropOldestResults() {
    for (std::size_t i = 0; i + 1 < ended_.size() && keptBytes_ > limits_.resultBytes; ++i) {
        if (ended_[i].bytes == 0) continue;
        ended_[i].job->dropResult();
        keptBytes_ -= std::exchange(ended_[i].bytes, 0);
    }
}

void JobIndex::expireOldest() {
    const Ended oldest = std::move(ended_.front());
    ended_.pop_front();
    keptBytes_ -= oldest.bytes;
    const std::string& id = oldest.job->id();
    jobs_.erase(id);
    if (expired_.insert(id).second) expiredOrder_.push_back(id);
    if (expiredOrder_.size() > kRemembered) {
        expired_.erase(expiredOrder_.front());
        expiredOrder_.pop_front();
    }
}

void JobIndex::forget(const std::string& id) {
    const std::lock_guard lock(mutex_);
    jobs_.erase(id);
    const auto found = std::find_if(ended_.begin(), ended_.end(),
                                    [&](const Ended& one) { return one.job->id() == id; });
    if (found == ended_.end()) return;
    keptBytes_ -= found->bytes;
    ended_.erase(found);
}

void JobIndex::sweep(Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    while (!ended_.empty() && ended_.front().expiry <= now) expireOldest();
}

}  // namespace rivage::server
