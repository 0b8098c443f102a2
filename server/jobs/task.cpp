#include "server/jobs/task.h"

#include <algorithm>
#include <utility>

namespace rivage::server {
namespace {

/// Share of the work that lies before each stage; a guess from typical runs, for the bar only.
constexpr std::array<double, core::kStageCount + 1> kShares{0, 0.02, 0.05, 0.55, 0.9, 0.9, 0.95, 1};

double milliseconds(Clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace

Task::Task(const Job& first, BlobPtr input, proto::JobOptions options, std::shared_ptr<void> place,
           bool suspect)
    : kind_(first.facts().kind),
      key_(first.facts().key),
      input_(std::move(input)),
      options_(std::move(options)),
      place_(std::move(place)),
      suspect_(suspect) {}

bool Task::join(const std::shared_ptr<Job>& job) {
    const std::lock_guard lock(mutex_);
    if (sealed_ || abandoned_) return false;
    jobs_.push_back(job);
    ++wanted_;
    if (running_ && job->start()) {
        job->advance(stage_, progress_);
        if (solver_) job->advance(*solver_);
    }
    return true;
}

void Task::leave(const Job& job) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(jobs_.begin(), jobs_.end(),
                                    [&](const auto& other) { return other.get() == &job; });
    if (found == jobs_.end()) return;
    jobs_.erase(found);
    if (--wanted_ == 0) abandon();  // nobody may join any more
}

bool Task::start() {
    const std::lock_guard lock(mutex_);
    running_ = true;
    stageBegan_ = Clock::now();
    beat();
    bool any = false;
    for (const auto& job : jobs_) any |= job->start();
    return any;
}

std::vector<std::shared_ptr<Job>> Task::seal() {
    const std::lock_guard lock(mutex_);
    sealed_ = true;
    return jobs_;
}

std::vector<std::shared_ptr<Job>> Task::jobs() const {
    const std::lock_guard lock(mutex_);
    return jobs_;
}

bool Task::serves(const Job& job) const {
    const std::lock_guard lock(mutex_);
    return std::any_of(jobs_.begin(), jobs_.end(),
                       [&](const auto& other) { return other.get() == &job; });
}

void Task::report(core::Stage stage, double fraction) {
    const std::lock_guard lock(mutex_);
    beat();
    if (stage != stage_) {
        const Clock::time_point now = Clock::now();
        times_[static_cast<std::size_t>(stage_)] += milliseconds(now - stageBegan_);
        stageBegan_ = now;
        stage_ = stage;
    }
    const auto index = static_cast<std::size_t>(stage);
    const double share = kShares[index + 1] - kShares[index];
    progress_ = std::max(progress_, kShares[index] + share * std::clamp(fraction, 0.0, 1.0));
    for (const auto& job : jobs_) job->advance(stage, progress_);
}

void Task::report(proto::SolverStep solver) {
    const std::lock_guard lock(mutex_);
    beat();
    solver_ = solver;
    for (const auto& job : jobs_) job->advance(solver);
}

void Task::offer(const JobPreview& preview) {
    const std::lock_guard lock(mutex_);
    for (const auto& job : jobs_) job->offer(preview);
}

std::array<double, core::kStageCount> Task::stageTimes() const {
    const std::lock_guard lock(mutex_);
    auto times = times_;
    times[static_cast<std::size_t>(stage_)] += milliseconds(Clock::now() - stageBegan_);
    return times;
}

bool Task::stopRequested() const {
    beat();
    return abandoned_;
}

void Task::abandon() {
    if (!abandoned_.exchange(true)) abandonedAt_ = Clock::now().time_since_epoch();
}

Clock::duration Task::abandonedFor(Clock::time_point now) const {
    const Clock::time_point since(abandonedAt_);
    return since == Clock::time_point() ? Clock::duration::zero() : now - since;
}

}  // namespace rivage::server
