#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/run_context.h"
#include "proto/options.h"
#include "server/jobs/job.h"

namespace rivage::server {

/// One run of the engine, for one job or for several identical ones. It goes on as long as one of
/// them wants it. Safe to use from several threads.
class Task {
public:
    /// @param place    given back when the task is gone; may be null
    /// @param suspect  its input was running at a crash, so it runs alone
    Task(const Job& first, BlobPtr input, proto::JobOptions options, std::shared_ptr<void> place,
         bool suspect);

    [[nodiscard]] JobKind kind() const { return kind_; }
    [[nodiscard]] const std::string& key() const { return key_; }
    [[nodiscard]] const BlobPtr& input() const { return input_; }
    [[nodiscard]] const std::shared_ptr<void>& place() const { return place_; }
    /// Gives the place back before the task is gone; by its worker only.
    void releasePlace() { place_.reset(); }
    [[nodiscard]] const proto::JobOptions& options() const { return options_; }
    [[nodiscard]] bool suspect() const { return suspect_; }

    /// Another identical job. @return false if the run is over, so that it must run by itself
    bool join(const std::shared_ptr<Job>& job);
    /// A job has ended before its run.
    void leave(const Job& job);
    /// The worker begins. @return false if no job is left
    bool start();
    /// No job joins from now on. @return those that the run was for
    [[nodiscard]] std::vector<std::shared_ptr<Job>> seal();
    [[nodiscard]] std::vector<std::shared_ptr<Job>> jobs() const;
    [[nodiscard]] bool serves(const Job& job) const;
    [[nodiscard]] bool wanted() const { return wanted_ > 0; }

    /// The engine's reports: measures the time of each stage and tells the jobs.
    void report(core::Stage stage, double fraction);
    void report(proto::SolverStep solver);
    void offer(const JobPreview& preview);
    /// The times of all stages, up to now.
    [[nodiscard]] std::array<double, core::kStageCount> stageTimes() const;

    /// Asks the engine to stop, whoever still wants it.
    void abandon();
    /// Polled by the engine; remembers when.
    [[nodiscard]] bool stopRequested() const;
    /// For how long it has been asked to stop.
    [[nodiscard]] Clock::duration abandonedFor(Clock::time_point now) const;
    /// When the engine last polled, or began.
    [[nodiscard]] Clock::time_point lastPoll() const { return Clock::time_point(lastPoll_); }

private:
    void beat() const { lastPoll_ = Clock::now().time_since_epoch(); }

    const JobKind kind_;
    const std::string key_;
    const BlobPtr input_;
    const proto::JobOptions options_;
    std::shared_ptr<void> place_;
    const bool suspect_;
    std::atomic<bool> abandoned_{false};
    std::atomic<std::size_t> wanted_{0};  ///< jobs that have not left
    std::atomic<Clock::duration> abandonedAt_{Clock::duration::zero()};
    mutable std::atomic<Clock::duration> lastPoll_{Clock::duration::zero()};

    mutable std::mutex mutex_;  ///< of what follows; taken before that of a job
    std::vector<std::shared_ptr<Job>> jobs_;
    bool running_ = false;
    bool sealed_ = false;
    core::Stage stage_ = core::Stage::parse;
    double progress_ = 0;
    std::optional<proto::SolverStep> solver_;
    Clock::time_point stageBegan_;
    std::array<double, core::kStageCount> times_{};
};

}  // namespace rivage::server
