#include "client/load/flow.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "client/load/taxonomy.h"

namespace rivage::client::load {
namespace {

/// The sums of a Server-Timing field: of "queue", and of everything else, in ms.
struct ServerTimes {
    double queue = 0;
    double compute = 0;
    bool known = false;
};

/// No conversion lasts longer: what says so, or is no number at all, is passed over.
constexpr double kMostMilliseconds = Histogram::kHighest / 1000.0;

ServerTimes readServerTiming(std::string_view field) {
    ServerTimes times;
    while (!field.empty()) {
        const std::size_t comma = std::min(field.find(','), field.size());
        std::string_view one = field.substr(0, comma);
        field.remove_prefix(std::min(comma + 1, field.size()));
        while (one.starts_with(' ')) one.remove_prefix(1);
        const std::size_t at = one.find(";dur=");
        if (at == std::string_view::npos) continue;
        double value = 0;
        const std::string_view number = one.substr(at + 5);
        const auto read = std::from_chars(number.data(), number.data() + number.size(), value);
        if (read.ec != std::errc() || !(value >= 0 && value <= kMostMilliseconds)) continue;
        (one.substr(0, at) == "queue" ? times.queue : times.compute) += value;
        times.known = true;
    }
    return times;
}

/// Microseconds of a sum of times that each are in bounds.
std::int64_t fromMilliseconds(double value) {
    return static_cast<std::int64_t>(std::min(value, kMostMilliseconds) * 1000);
}

/// Whether this is the path of a job: it is sent back, so nothing but a plain id may follow.
bool isJob(std::string_view path) {
    constexpr std::string_view kJobs = "/v1/jobs/";
    if (!path.starts_with(kJobs) || path.size() == kJobs.size() || path.size() > 256) return false;
    path.remove_prefix(kJobs.size());
    return std::all_of(path.begin(), path.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '-' || c == '_';
    });
}

constexpr std::chrono::milliseconds kSettlePause{5};
/// The class of answers that say nothing we know.
constexpr const char* kNotUnderstood = "not-understood";

}  // namespace

std::int64_t microseconds(TimePoint from, TimePoint to) {
    return std::max<std::int64_t>(
        0, std::chrono::duration_cast<std::chrono::microseconds>(to - from).count());
}

Flow::Flow(FlowHost& flowHost, const PreparedEntry& what, int index, const FlowDraw& chance)
    : host(flowHost), prepared(what), entry(index), draw(chance) {}

void Flow::sendFirst() {
    head = draw.duplicate ? prepared.kept : prepared.fresh;
    body = prepared.body;
    keep = draw.verify ? Keep::all : Keep::errors;
    if (draw.abortAfter) host.wake(*this, Clock::now() + *draw.abortAfter);
    host.send(*this);
}

void Flow::start() { sendFirst(); }

void Flow::woken() { host.breakOff(*this); }

void Flow::finish(Ending how, std::string errorName) {
    ending = how;
    error = std::move(errorName);
    host.finish(*this);
}

bool Flow::endedBadly() {
    if (fault == Fault::aborted) {
        finish(Ending::aborted);
        return true;
    }
    std::string name = errorClass(*this);
    if (name.empty()) return false;
    finish(isRefusal(*this) ? Ending::refused : Ending::failed, std::move(name));
    return true;
}

void Flow::measurePhases() {
    if (draw.slow) return;
    Tally& tally = host.tally(*this);
    if (!reused) {
        tally[Measure::connect].record(microseconds(begun, connected));
        if (secured != connected) tally[Measure::tls].record(microseconds(connected, secured));
    }
    if (written == TimePoint{} || firstByte == TimePoint{}) return;
    tally[Measure::upload].record(microseconds(secured, written));
    tally[Measure::wait].record(microseconds(written, firstByte));
    tally[Measure::download].record(microseconds(firstByte, ended));
}

void Flow::measureServer() {
    const ServerTimes times = readServerTiming(answer.field("server-timing"));
    if (!times.known || draw.slow) return;
    Tally& tally = host.tally(*this);
    const std::int64_t queue = fromMilliseconds(times.queue);
    const std::int64_t compute = fromMilliseconds(times.compute);
    tally[Measure::serverQueue].record(queue);
    tally[Measure::serverCompute].record(compute);
    tally[Measure::serverOverhead].record(
        std::max<std::int64_t>(0, microseconds(standing, ended) - queue - compute));
}

void SingleFlow::onEnded() {
    standing = secured;
    if (fault == Fault::none) measurePhases();
    if (endedBadly()) return;
    if (prepared.entry.mode == Mode::sync) measureServer();
    if (draw.verify) host.verify(*this);
    finish(Ending::good);
}

void JobFlow::request(Step step, std::string_view method, const std::string& path,
                      std::string_view fields) {
    step_ = step;
    head_ = host.heads().write(method, path, fields);
    head = head_;
    body = {};
    keep = Keep::all;
    streamed = step == Step::events;
    host.send(*this);
}

void JobFlow::onEnded() {
    if (step_ == Step::submit) {
        standing = secured;
        if (fault == Fault::none) measurePhases();
        if (!endedBadly()) accepted();
        return;
    }
    // Broken off in order to cancel.
    if (fault == Fault::aborted && cancelling_ && step_ != Step::cancel)
        return request(Step::cancel, "DELETE", job_);
    if (step_ == Step::cancel || step_ == Step::settle) return cancelSettled();
    if (step_ == Step::result) {
        if (endedBadly()) return;
        if (draw.verify) host.verify(*this);
        Tally& tally = host.tally(*this);
        ++tally.jobs;
        tally[Measure::jobResult].record(microseconds(sentAt, ended));
        return finish(Ending::good);
    }
    if (endedBadly()) return;
    step_ == Step::events ? readEvents() : readState();
}

void JobFlow::accepted() {
    job_ = answer.field("location");
    if (answer.status() != 202)
        return finish(Ending::failed, "unexpected " + std::to_string(answer.status()));
    if (!isJob(job_)) return finish(Ending::failed, "bad-location");
    if (draw.abandoned) return finish(Ending::abandoned);
    if (draw.cancelled) host.wake(*this, Clock::now() + prepared.entry.cancelAfter);
    follow();
}

void JobFlow::follow() {
    if (prepared.entry.follow == Follow::events)
        return request(Step::events, "GET", job_ + "/events");
    ++host.tally(*this).polls;
    const bool waits = prepared.entry.follow == Follow::wait;
    request(Step::state, "GET", job_, waits ? "Prefer: wait=10\r\n" : "");
}

void JobFlow::onGrown() {
    if (eventSeen_ || answer.body().find("\nevent:") == std::string::npos) return;
    eventSeen_ = true;
    host.tally(*this)[Measure::jobFirstEvent].record(microseconds(begun, Clock::now()));
}

/// The last event of a stream is the job as it has ended.
void JobFlow::readEvents() {
    const std::string& text = answer.body();
    const std::size_t done = text.rfind("event: done\ndata: ");
    if (done == std::string::npos) return finish(Ending::failed, "events without an end");
    const std::size_t begin = done + 18;
    const std::string_view document =
        std::string_view(text).substr(begin, text.find('\n', begin) - begin);
    stateKnown(readAnswer(document));
}

void JobFlow::readState() { stateKnown(readAnswer(answer.body())); }

void JobFlow::stateKnown(const proto::Json& job) {
    const std::string state = textOf(job, "state");
    if (state == "succeeded") return request(Step::result, "GET", job_ + "/result");
    if (state == "canceled") return finish(Ending::failed, "job-canceled");
    if (state == "queued" || state == "running") {
        step_ = Step::pause;
        const bool polls = prepared.entry.follow == Follow::poll;
        const auto pause = polls ? prepared.entry.pollEvery : std::chrono::milliseconds(1);
        return host.wake(*this, Clock::now() + pause);
    }
    if (state != "failed") return finish(Ending::failed, kNotUnderstood);
    const std::string slug = job.contains("error") ? slugOf(job["error"]) : std::string();
    finish(Ending::failed, slug.empty() ? "job-failed" : "job-failed " + slug);
}

/// Woken to poll, or to cancel; the last is told by its time.
void JobFlow::woken() {
    if (cancelling_) {
        if (step_ == Step::pause) request(Step::settle, "GET", job_, "Prefer: wait=10\r\n");
        return;
    }
    const bool cancelDue =
        draw.cancelled && Clock::now() >= sentAt + prepared.entry.cancelAfter && !job_.empty();
    if (cancelDue) return beginCancel();
    if (step_ == Step::pause)
        follow();
    else if (step_ == Step::submit && draw.abortAfter)
        host.breakOff(*this);
}

void JobFlow::beginCancel() {
    if (step_ == Step::result) return;  // it is over: there is nothing to cancel
    cancelling_ = true;
    cancelAt_ = Clock::now();
    if (step_ == Step::pause) return request(Step::cancel, "DELETE", job_);
    host.breakOff(*this);
}

/// After DELETE the job is asked for until it has ended.
void JobFlow::cancelSettled() {
    const int status = answer.status();
    const bool gone = fault == Fault::none && (status == 404 || status == 410);
    if (!gone && endedBadly()) return;
    if (step_ == Step::cancel && !gone) {
        step_ = Step::pause;
        return host.wake(*this, Clock::now() + std::chrono::milliseconds(0));
    }
    const std::string state = gone ? "" : textOf(readAnswer(answer.body()), "state");
    if (!gone && state.empty()) return finish(Ending::failed, kNotUnderstood);
    if (!gone && (state == "queued" || state == "running")) {
        step_ = Step::pause;
        return host.wake(*this, Clock::now() + kSettlePause);
    }
    host.tally(*this)[Measure::jobCancel].record(microseconds(cancelAt_, ended));
    finish(Ending::cancelled);
}

std::unique_ptr<Flow> makeFlow(FlowHost& host, const PreparedEntry& prepared, int index,
                               const FlowDraw& draw) {
    if (prepared.entry.mode == Mode::job)
        return std::make_unique<JobFlow>(host, prepared, index, draw);
    return std::make_unique<SingleFlow>(host, prepared, index, draw);
}

}  // namespace rivage::client::load
