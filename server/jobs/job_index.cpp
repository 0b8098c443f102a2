#include "server/jobs/job_index.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace rivage::server {
namespace {

using core::ErrorCode;

/// Jobs remembered to answer "expired" instead of "not found", in memory that does not grow.
constexpr std::size_t kRemembered = 16384;

/// What is left of a job that has expired; that two have the same is out of the question.
std::uint64_t remains(const std::string& owner, const std::string& id) {
    return std::hash<std::string>{}(owner + '\n' + id);
}

}  // namespace

JobIndex::JobIndex(const StoreLimits& limits) : limits_(limits), expired_(kRemembered) {}

void JobIndex::add(std::shared_ptr<Job> job) {
    const std::lock_guard lock(mutex_);
    jobs_.emplace(job->id(), std::move(job));
}

core::Result<std::shared_ptr<Job>> JobIndex::find(const std::string& owner,
                                                  const std::string& id) const {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found != jobs_.end() && found->second->facts().owner == owner) return found->second;
    if (std::find(expired_.begin(), expired_.end(), remains(owner, id)) != expired_.end())
        return core::fail(ErrorCode::expired, "this job has expired", "/id");
    return core::fail(ErrorCode::notFound, "there is no job with this id", "/id");
}

std::vector<std::shared_ptr<Job>> JobIndex::list(const JobQuery& query) const {
    std::vector<std::shared_ptr<Job>> list;
    const std::lock_guard lock(mutex_);
    auto end = query.after.empty() ? jobs_.end() : jobs_.lower_bound(query.after);
    while (end != jobs_.begin() && list.size() < query.limit) {
        --end;
        const Job& job = *end->second;
        if (job.facts().owner == query.owner && (!query.state || job.state() == *query.state))
            list.push_back(end->second);
    }
    return list;
}

void JobIndex::ended(const std::shared_ptr<Job>& job) {
    const auto wall = std::chrono::system_clock::now();
    const auto expiry = job->snapshot().view.expiresAt.value_or(wall + limits_.resultTtl);
    job->setExpiry(expiry);
    const JobRecord record = job->record();

    const std::lock_guard lock(mutex_);
    if (!jobs_.contains(job->id())) return;  // forgotten while it ran
    ended_.push_back({job,
                      Clock::now() + std::chrono::duration_cast<Clock::duration>(expiry - wall),
                      record.resultSha256});
    count(record.resultSha256, record.resultBytes);
    dropOldestResults();
    while (ended_.size() > limits_.jobs) expireOldest();
}

/// Identical jobs share the bytes of their result. With the mutex held.
void JobIndex::count(const std::string& result, std::uint64_t bytes) {
    if (result.empty()) return;
    Kept& kept = results_[result];
    if (kept.jobs++ > 0) return;
    kept.bytes = bytes;
    keptBytes_ += bytes;
}

/// With the mutex held.
void JobIndex::uncount(std::string& result) {
    const auto found = results_.find(std::exchange(result, {}));
    if (found == results_.end() || --found->second.jobs > 0) return;
    keptBytes_ -= found->second.bytes;
    results_.erase(found);
}

/// The newest result is kept even if it alone fills the room: its client waits for it.
void JobIndex::dropOldestResults() {
    for (std::size_t i = 0; i + 1 < ended_.size() && keptBytes_ > limits_.resultBytes; ++i) {
        if (ended_[i].result.empty()) continue;
        uncount(ended_[i].result);
        ended_[i].job->dropResult();
        changes_.changed.push_back(ended_[i].job);
    }
}

void JobIndex::expireOldest() {
    Ended oldest = std::move(ended_.front());
    ended_.pop_front();
    uncount(oldest.result);
    const std::string& id = oldest.job->id();
    jobs_.erase(id);
    changes_.gone.push_back(id);
    expired_[nextExpired_++ % kRemembered] = remains(oldest.job->facts().owner, id);
}

void JobIndex::forget(const std::string& id) {
    const std::lock_guard lock(mutex_);
    jobs_.erase(id);
    changes_.gone.push_back(id);
    const auto found = std::find_if(ended_.begin(), ended_.end(),
                                    [&](const Ended& one) { return one.job->id() == id; });
    if (found == ended_.end()) return;
    uncount(found->result);
    ended_.erase(found);
}

void JobIndex::sweep(Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    while (!ended_.empty() && ended_.front().expiry <= now) expireOldest();
}

JobIndex::Changes JobIndex::takeChanges() {
    const std::lock_guard lock(mutex_);
    return std::exchange(changes_, {});
}

std::set<std::string> JobIndex::needed() const {
    std::set<std::string> needed;
    const std::lock_guard lock(mutex_);
    for (const auto& [hex, kept] : results_) needed.insert(hex);
    for (const auto& [id, job] : jobs_)
        if (!proto::hasEnded(job->state())) needed.insert(job->facts().inputSha256);
    return needed;
}

}  // namespace rivage::server
