#include "server/jobs/job.h"

#include <algorithm>
#include <utility>

#include "server/jobs/digest.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using proto::JobState;

/// Share of the work that lies before each stage; a guess from typical runs, for the bar only.
constexpr std::array<double, core::kStageCount + 1> kShares{0, 0.05, 0.12, 0.25, 0.8, 0.9, 1};

double milliseconds(Clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace

Job::Job(std::string id, JobRequest request, Clock::time_point deadline)
    : id_(std::move(id)), request_(std::move(request)), deadline_(deadline) {
    now_.view.id = id_;
    now_.view.created = std::chrono::system_clock::now();
    now_.view.options = proto::toJson(request_.options);
    now_.requestId = request_.requestId;
    now_.inputBytes = request_.input.size();
}

bool Job::start() {
    const std::lock_guard lock(mutex_);
    if (proto::hasEnded(now_.view.state)) return false;
    now_.view.state = JobState::running;
    now_.view.started = std::chrono::system_clock::now();
    ++now_.view.attempt;
    stageBegan_ = Clock::now();
    now_.times.queue = milliseconds(stageBegan_ - created_);
    return true;
}

void Job::report(core::Stage stage, double fraction) {
    const std::lock_guard lock(mutex_);
    const auto index = static_cast<std::size_t>(stage);
    if (now_.view.stage != stage) {
        const Clock::time_point now = Clock::now();
        // What was spent before the first stage was named belongs to the first.
        const auto before = static_cast<std::size_t>(now_.view.stage.value_or(stage));
        now_.times.stages[before] += milliseconds(now - stageBegan_);
        stageBegan_ = now;
        now_.view.stage = stage;
    }
    const double share = kShares[index + 1] - kShares[index];
    const double progress = kShares[index] + share * std::clamp(fraction, 0.0, 1.0);
    now_.view.progress = std::max(now_.view.progress, progress);
}

/// With the mutex held.
void Job::keepReport(core::ConversionReport& report, std::size_t bytes) {
    now_.voxels = report.input.voxels;
    now_.surfels = report.surface.surfels;
    if (request_.kind == JobKind::inspect) return;
    report.milliseconds = now_.times.stages;
    report.output.bytes = bytes;
    now_.view.report = core::toJson(report);
}

void Job::finish(core::Result<core::Artifact> outcome) {
    std::shared_ptr<const JobResult> result;
    if (outcome && !cancelled_) {
        const Digest digest = sha256(outcome->bytes);
        result = std::make_shared<const JobResult>(JobResult{
            std::move(outcome->bytes), outcome->mediaType, request_.name + "." + outcome->extension,
            '"' + digest.hex + '"', "sha-256=:" + digest.base64 + ":"});
    }
    const std::lock_guard lock(mutex_);
    const auto stage = static_cast<std::size_t>(now_.view.stage.value_or(core::Stage::parse));
    now_.times.stages[stage] += milliseconds(Clock::now() - stageBegan_);
    if (cancelled_)
        return end(JobState::canceled, core::Error{ErrorCode::cancelled, "the job was canceled"});
    if (!outcome) {
        const bool canceled = outcome.error().code == ErrorCode::cancelled;
        return end(canceled ? JobState::canceled : JobState::failed, std::move(outcome.error()));
    }
    keepReport(outcome->report, result->bytes.size());
    now_.result = std::move(result);
    end(JobState::succeeded, std::nullopt);
}

void Job::announce() {
    const std::lock_guard lock(mutex_);
    announced_ = true;
    announcement_.notify_all();
}

/// With the mutex held.
void Job::end(JobState state, std::optional<core::Error> error) {
    now_.view.state = state;
    now_.view.finished = std::chrono::system_clock::now();
    if (state == JobState::succeeded) now_.view.progress = 1;
    if (error) {
        now_.view.error = proto::makeProblem(*error);
        now_.view.error->instance = "/v1/jobs/" + id_;
    }
    now_.error = std::move(error);
    now_.view.hasResult = now_.result != nullptr;
    std::vector<std::byte>().swap(request_.input);
}

bool Job::cancel() {
    const std::lock_guard lock(mutex_);
    if (proto::hasEnded(now_.view.state)) return false;
    cancelled_ = true;
    if (now_.view.state == JobState::running) return false;
    now_.times.queue = milliseconds(Clock::now() - created_);
    end(JobState::canceled, core::Error{ErrorCode::cancelled, "the job was canceled"});
    return true;
}

bool Job::expire(Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    if (now_.view.state != JobState::queued || now < deadline_) return false;
    now_.times.queue = milliseconds(now - created_);
    end(JobState::failed,
        core::Error{ErrorCode::timedOut, "the deadline passed while the job was queued"});
    return true;
}

bool Job::stopRequested() const { return cancelled_ || Clock::now() >= deadline_; }

ErrorCode Job::stopReason() const {
    return cancelled_ ? ErrorCode::cancelled : ErrorCode::timedOut;
}

bool Job::waitEnded(std::chrono::milliseconds timeout) const {
    std::unique_lock lock(mutex_);
    return announcement_.wait_for(lock, timeout, [&] { return announced_; });
}

JobState Job::state() const {
    const std::lock_guard lock(mutex_);
    return now_.view.state;
}

JobSnapshot Job::snapshot() const {
    const std::lock_guard lock(mutex_);
    return now_;
}

void Job::dropResult() {
    const std::lock_guard lock(mutex_);
    now_.result.reset();
    now_.view.hasResult = false;
}

void Job::setExpiry(proto::WallTime expiry) {
    const std::lock_guard lock(mutex_);
    now_.view.expiresAt = expiry;
}

}  // namespace rivage::server
