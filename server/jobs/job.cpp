#include "server/jobs/job.h"

#include <algorithm>
#include <utility>

namespace rivage::server {
namespace {

using proto::JobState;

/// Events kept for those who come late or come back.
constexpr std::size_t kKeptEvents = 256;
/// Between two events that only say how far a stage is.
constexpr std::chrono::milliseconds kProgressInterval{100};

proto::Json parsed(const std::string& text) {
    return text.empty() ? proto::Json() : proto::Json::parse(text, nullptr, false);
}

std::optional<core::Stage> stageOf(const std::string& name) {
    for (std::size_t i = 0; i < core::kStageCount; ++i)
        if (name == core::stageName(static_cast<core::Stage>(i)))
            return static_cast<core::Stage>(i);
    return std::nullopt;
}

JobFacts factsOf(const JobRecord& record) {
    return {.id = record.id,
            .kind = JobKind::convert,
            .owner = record.owner,
            .idempotencyKey = record.idempotencyKey,
            .key = record.key,
            .options = record.options,
            .progressive = parsed(record.options).value("progressive", false),
            .name = record.name,
            .requestId = record.requestId,
            .traceparent = record.traceparent,
            .inputSha256 = record.inputSha256,
            .inputBytes = record.inputBytes,
            .created = record.created};
}

}  // namespace

JobResult::JobResult(BlobPtr bytes, std::string type, std::string suffix)
    : blob(std::move(bytes)),
      mediaType(std::move(type)),
      extension(std::move(suffix)),
      etag('"' + blob->digest().hex + '"'),
      reprDigest("sha-256=:" + blob->digest().base64 + ":") {}

Job::Job(JobFacts facts, Clock::time_point deadline)
    : facts_(std::move(facts)), deadline_(deadline) {
    now_.view.id = facts_.id;
    now_.view.name = facts_.name;
    now_.view.created = facts_.created;
}

Job::Job(const JobRecord& record, Clock::time_point deadline) : Job(factsOf(record), deadline) {
    durable_ = true;
    now_.view.attempt = record.attempt;
    if (!proto::hasEnded(record.state)) return;
    now_.view.state = record.state;
    now_.view.started = record.started;
    now_.view.finished = record.finished;
    now_.view.expiresAt = record.expires;
    now_.view.progress = record.state == JobState::succeeded ? 1 : 0;
    now_.view.stage = stageOf(record.stage);
    now_.error = record.error;
    if (record.error) {
        now_.view.error = proto::makeProblem(*record.error);
        now_.view.error->instance = "/v1/jobs/" + record.id;
    }
    resultSha256_ = record.resultSha256;
    resultBytes_ = record.resultBytes;
    mediaType_ = record.mediaType;
    extension_ = record.extension;
    now_.view.hasResult = !resultSha256_.empty();
    if (!record.report.empty()) now_.facts = std::make_shared<RunFacts>(RunFacts{record.report});
    announced_ = true;
}

bool Job::start() {
    const std::lock_guard lock(mutex_);
    if (ended()) return false;
    now_.view.state = JobState::running;
    now_.view.started = std::chrono::system_clock::now();
    ++now_.view.attempt;
    now_.times.queue = std::chrono::duration<double, std::milli>(Clock::now() - created_).count();
    addProgressEvent();
    return true;
}

void Job::advance(core::Stage stage, double progress) {
    const std::lock_guard lock(mutex_);
    if (ended()) return;
    const bool next = now_.view.stage != stage;
    const bool further = progress > now_.view.progress;
    now_.view.stage = stage;
    now_.view.progress = std::max(now_.view.progress, progress);
    if (next || (further && Clock::now() - lastProgress_ >= kProgressInterval)) addProgressEvent();
}

void Job::advance(proto::SolverStep solver) {
    const std::lock_guard lock(mutex_);
    if (ended()) return;
    now_.view.solver = solver;
    addProgressEvent();
}

void Job::advanceInQueue(std::size_t position) {
    const std::lock_guard lock(mutex_);
    if (now_.view.state == JobState::queued) addProgressEvent(position);
}

void Job::offer(JobPreview preview) {
    const std::lock_guard lock(mutex_);
    if (ended()) return;
    addEvent("preview", {{"step", preview.step},
                         {"energy", preview.energy},
                         {"href", "/v1/jobs/" + id() + "/preview"}});
    preview_ = std::move(preview);
}

std::optional<JobPreview> Job::preview() const {
    const std::lock_guard lock(mutex_);
    return preview_;
}

/// With the mutex held.
void Job::addEvent(const char* name, const proto::Json& data) {
    events_.push_back({++lastEvent_, name, proto::writeJson(data)});
    if (events_.size() > kKeptEvents) events_.pop_front();
    changed_.notify_all();
}

/// With the mutex held.
void Job::addProgressEvent(std::optional<std::size_t> position) {
    lastProgress_ = Clock::now();
    proto::JobView view = now_.view;
    view.queuePosition = position;
    addEvent("progress", proto::progressJson(view));
}

bool Job::end(const RunOutcome& outcome, std::chrono::seconds kept) {
    const std::lock_guard lock(mutex_);
    if (ended()) return false;
    proto::JobView& view = now_.view;
    if (view.state == JobState::queued)
        now_.times.queue =
            std::chrono::duration<double, std::milli>(Clock::now() - created_).count();
    view.finished = std::chrono::system_clock::now();
    if (kept.count() > 0) view.expiresAt = *view.finished + kept;
    view.state = outcome.result ? JobState::succeeded : JobState::failed;
    if (outcome.error) {
        if (outcome.error->code == core::ErrorCode::cancelled) view.state = JobState::canceled;
        view.error = proto::makeProblem(*outcome.error);
        view.error->instance = "/v1/jobs/" + id();
    }
    if (outcome.result) {
        view.progress = 1;
        resultSha256_ = outcome.result->blob->digest().hex;
        resultBytes_ = outcome.result->size();
        mediaType_ = outcome.result->mediaType;
        extension_ = outcome.result->extension;
    }
    view.hasResult = outcome.result != nullptr;
    now_.error = outcome.error;
    now_.result = outcome.result;
    now_.facts = outcome.facts;
    if (outcome.facts && now_.reuse != Reuse::hit) now_.times.stages = outcome.facts->stages;
    preview_.reset();
    return true;
}

void Job::setReuse(Reuse reuse) {
    const std::lock_guard lock(mutex_);
    now_.reuse = reuse;
}

void Job::announce() {
    const std::lock_guard lock(mutex_);
    announced_ = true;
    changed_.notify_all();
}

bool Job::announced() const {
    const std::lock_guard lock(mutex_);
    return announced_;
}

bool Job::waitEnded(std::chrono::milliseconds timeout) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, timeout, [&] { return announced_; });
}

std::vector<JobEvent> Job::waitEvents(std::uint64_t after,
                                      std::chrono::milliseconds timeout) const {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [&] { return announced_ || lastEvent_ > after; });
    std::vector<JobEvent> events;
    for (const JobEvent& event : events_)
        if (event.id > after) events.push_back(event);
    return events;
}

JobState Job::state() const {
    const std::lock_guard lock(mutex_);
    return now_.view.state;
}

JobSnapshot Job::snapshot() const {
    const std::lock_guard lock(mutex_);
    return now_;
}

proto::JobView Job::view() const {
    const JobSnapshot snapshot = this->snapshot();
    proto::JobView view = snapshot.view;
    view.options = parsed(facts_.options);
    if (snapshot.facts) view.report = parsed(snapshot.facts->report);
    return view;
}

JobRecord Job::record() const {
    const std::lock_guard lock(mutex_);
    const proto::JobView& view = now_.view;
    return {.id = facts_.id,
            .owner = facts_.owner,
            .idempotencyKey = facts_.idempotencyKey,
            .key = facts_.key,
            .options = facts_.options,
            .name = facts_.name,
            .requestId = facts_.requestId,
            .traceparent = facts_.traceparent,
            .inputSha256 = facts_.inputSha256,
            .inputBytes = facts_.inputBytes,
            .state = view.state,
            .stage = view.stage ? core::stageName(*view.stage) : "",
            .attempt = view.attempt,
            .created = view.created,
            .started = view.started,
            .finished = view.finished,
            .expires = view.expiresAt,
            .resultSha256 = resultSha256_,
            .resultBytes = resultBytes_,
            .mediaType = mediaType_,
            .extension = extension_,
            .report = now_.facts ? now_.facts->report : std::string(),
            .error = now_.error};
}

void Job::makeDurable() {
    const std::lock_guard lock(mutex_);
    durable_ = true;
}

bool Job::durable() const {
    const std::lock_guard lock(mutex_);
    return durable_;
}

void Job::addWaiter() {
    const std::lock_guard lock(mutex_);
    ++waiters_;
}

bool Job::removeWaiter() {
    const std::lock_guard lock(mutex_);
    return --waiters_ == 0 && !durable_;
}

void Job::restoreResult(ResultPtr result) {
    const std::lock_guard lock(mutex_);
    if (now_.view.hasResult) now_.result = std::move(result);
}

void Job::dropResult() {
    const std::lock_guard lock(mutex_);
    now_.result.reset();
    now_.view.hasResult = false;
    resultSha256_.clear();
    resultBytes_ = 0;
}

void Job::setExpiry(proto::WallTime expiry) {
    const std::lock_guard lock(mutex_);
    now_.view.expiresAt = expiry;
}

}  // namespace rivage::server
