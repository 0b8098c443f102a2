#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/jobs/job.h"

namespace rivage::server {

/// Which jobs to list.
struct JobQuery {
    std::string owner = {};
    std::optional<proto::JobState> state = {};
    std::string after = {};  ///< only jobs older than the one with this id
    std::size_t limit = 50;
};

struct StoreLimits {
    std::chrono::seconds resultTtl{86400};
    std::uint64_t resultBytes = 512ULL << 20;  ///< of all kept results; the oldest go first
    std::size_t jobs = 1000;                   ///< ended jobs; the oldest go first
};

/// Where jobs can be found by id, while they run and for some time after.
class JobIndex {
public:
    explicit JobIndex(const StoreLimits& limits);
    void add(std::shared_ptr<Job> job);
    /// Of this owner only. @errors notFound; expired if it was here
    [[nodiscard]] core::Result<std::shared_ptr<Job>> find(const std::string& owner,
                                                          const std::string& id) const;
    /// Newest first.
    [[nodiscard]] std::vector<std::shared_ptr<Job>> list(const JobQuery& query) const;
    /// For how long a job is known after its end.
    [[nodiscard]] std::chrono::seconds resultTtl() const { return limits_.resultTtl; }
    /// A job has ended: its time to live begins, and its bytes count against the room for results.
    void ended(const std::shared_ptr<Job>& job);
    void forget(const std::string& id);
    /// Drops what has outlived its time.
    void sweep(Clock::time_point now);

    /// What has happened to ended jobs since the last call.
    struct Changes {
        std::vector<std::string> gone;              ///< ids
        std::vector<std::shared_ptr<Job>> changed;  ///< those without their result now
    };
    [[nodiscard]] Changes takeChanges();
    /// The blobs that jobs need, by their sha-256 (hex): grids until the end, results after it.
    [[nodiscard]] std::set<std::string> needed() const;

private:
    struct Ended {
        std::shared_ptr<Job> job;
        Clock::time_point expiry;
        std::string result = {};  ///< hex; empty without one
    };
    void expireOldest();
    void dropOldestResults();
    void count(const std::string& result, std::uint64_t bytes);
    void uncount(std::string& result);

    const StoreLimits limits_;
    mutable std::mutex mutex_;
    std::map<std::string, std::shared_ptr<Job>> jobs_;  ///< ids sort by time
    std::deque<Ended> ended_;                           ///< in the order in which they ended
    struct Kept {
        std::size_t jobs = 0;  ///< that share this result
        std::uint64_t bytes = 0;
    };
    std::map<std::string, Kept> results_;  ///< of ended jobs, by sha-256
    std::uint64_t keptBytes_ = 0;
    std::vector<std::uint64_t> expired_;  ///< digests of owners and ids that were here; a ring
    std::size_t nextExpired_ = 0;
    Changes changes_;
};

}  // namespace rivage::server
