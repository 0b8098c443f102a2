#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/pipeline.h"
#include "proto/job.h"
#include "proto/options.h"

namespace rivage::server {

using Clock = std::chrono::steady_clock;

enum class JobKind : std::uint8_t {
    convert,  ///< grid to asset
    inspect,  ///< grid to what is in it; not listed, not kept
};

/// What is to be done, as it was accepted.
struct JobRequest {
    JobKind kind = JobKind::convert;
    std::vector<std::byte> input = {};
    proto::JobOptions options = {};
    std::string name = "rivage";  ///< of the grid, without extension; safe in a header
    std::string requestId = {};
};

/// The bytes that a job made; they never change.
struct JobResult {
    std::vector<std::byte> bytes;
    std::string mediaType;
    std::string fileName;
    std::string etag;        ///< strong, quoted
    std::string reprDigest;  ///< RFC 9530
};

/// Milliseconds that a job has spent.
struct JobTimes {
    double queue = 0;
    std::array<double, core::kStageCount> stages{};
};

/// What a job is at one moment.
struct JobSnapshot {
    proto::JobView view;  ///< without its place in the queue
    std::optional<core::Error> error = {};
    std::shared_ptr<const JobResult> result = {};
    JobTimes times = {};
    std::string requestId = {};
    std::size_t inputBytes = 0;
    std::uint64_t voxels = 0;
    std::uint64_t surfels = 0;
};

/// One job and its states: queued -> running -> succeeded, failed or canceled; a queued job may be
/// canceled or fail by its deadline. Safe to use from several threads.
class Job {
public:
    /// @param deadline  when it must have ended; counted from acceptance
    Job(std::string id, JobRequest request, Clock::time_point deadline);

    [[nodiscard]] const std::string& id() const { return id_; }
    [[nodiscard]] JobKind kind() const { return request_.kind; }
    [[nodiscard]] const proto::JobOptions& options() const { return request_.options; }
    [[nodiscard]] Clock::time_point deadline() const { return deadline_; }

    /// The worker takes the job. @return false if it has ended already
    [[nodiscard]] bool start();
    /// The grid, for the worker between `start` and `finish`.
    [[nodiscard]] const std::vector<std::byte>& input() const { return request_.input; }
    /// A stage begins or goes on; measures the time of each.
    void report(core::Stage stage, double fraction);
    /// The worker is done. Cancellation wins over success. Frees the grid.
    void finish(core::Result<core::Artifact> outcome);
    /// Wakes those that wait for the end, once all bookkeeping is done.
    void announce();

    /// Asks the job to stop. @return whether it ended at once, because it was still queued
    bool cancel();
    /// Ends a queued job whose deadline has passed. @return whether it did
    bool expire(Clock::time_point now);
    [[nodiscard]] bool stopRequested() const;
    [[nodiscard]] core::ErrorCode stopReason() const;

    /// Waits until the end was announced or `timeout` is over. @return whether it was announced
    [[nodiscard]] bool waitEnded(std::chrono::milliseconds timeout) const;
    [[nodiscard]] proto::JobState state() const;
    [[nodiscard]] JobSnapshot snapshot() const;

    /// The bytes are given up, because their time is over or others need the room.
    void dropResult();
    /// When an ended job is to be forgotten; set by whoever keeps it.
    void setExpiry(proto::WallTime expiry);

private:
    void end(proto::JobState state, std::optional<core::Error> error);
    void keepReport(core::ConversionReport& report, std::size_t bytes);

    const std::string id_;
    JobRequest request_;
    const Clock::time_point created_ = Clock::now();
    const Clock::time_point deadline_;
    std::atomic<bool> cancelled_{false};

    mutable std::mutex mutex_;
    mutable std::condition_variable announcement_;
    bool announced_ = false;
    JobSnapshot now_;
    Clock::time_point stageBegan_;
};

}  // namespace rivage::server
