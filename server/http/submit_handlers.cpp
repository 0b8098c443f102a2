#include <utility>

#include "server/http/form_parser.h"
#include "server/http/job_answers.h"
#include "server/http/prefer.h"
#include "server/http/routes.h"
#include "server/http/text.h"
#include "server/http/upload.h"
#include "server/jobs/idempotency.h"
#include "server/net/answer.h"

namespace rivage::server {
namespace {

using core::ErrorCode;

/// How often a waiting request looks whether its client is still there.
constexpr std::chrono::milliseconds kPollInterval{50};

/// Query parameters are options, whatever their name.
std::vector<proto::OptionText> queryOptions(const httplib::Request& request) {
    std::vector<proto::OptionText> options;
    for (auto& [name, value] : queryOf(request))
        options.push_back({std::move(name), std::move(value)});
    return options;
}

/// The idempotency key of a request, or nothing. @errors malformedRequest
core::Result<std::string> idempotencyKeyOf(const httplib::Request& request) {
    if (!request.has_header("Idempotency-Key")) return std::string();
    if (request.get_header_value_count("Idempotency-Key") > 1)
        return core::fail(ErrorCode::malformedRequest, "there is more than one Idempotency-Key",
                          "/headers/idempotency-key");
    return readIdempotencyKey(request.get_header_value("Idempotency-Key"));
}

bool asksForFreshResult(const httplib::Request& request) {
    return lowerCase(listField(request, "Cache-Control")).find("no-cache") != std::string::npos;
}

/// Reads grid and options, after `checkSubmission`.
Answer<JobRequest> readRequest(Exchange& exchange, JobKind kind) {
    auto upload = readUpload(exchange);
    if (!upload) return tl::unexpected(upload.error());
    auto options = proto::parseOptions(queryOptions(exchange.request), upload->options);
    if (!options) return problem(options.error());

    JobRequest request{kind, std::move(upload->grid), *std::move(options)};
    if (!upload->name.empty()) request.name = std::move(upload->name);
    request.owner = exchange.owner;
    request.traceparent = exchange.traceparent;
    request.requestId = exchange.response.get_header_value("X-Request-ID");
    request.fresh = asksForFreshResult(exchange.request);
    return request;
}

/// The job of an earlier request with the same idempotency key, if this is the same request.
Answer<std::shared_ptr<Job>> replay(Exchange& exchange, const std::shared_ptr<Job>& job,
                                    const JobRequest& request) {
    if (job->facts().inputSha256 != sha256(request.input).hex ||
        job->facts().options != proto::writeJson(proto::toJson(request.options)))
        return problem({ErrorCode::keyReused,
                        "the Idempotency-Key came first with another grid or other options",
                        "/headers/idempotency-key"});
    exchange.response.set_header("Idempotent-Replayed", "true");
    return job;
}

/// RFC 9211: whether the answer was made for this request.
const char* cacheStatus(Reuse reuse) {
    switch (reuse) {
        case Reuse::none: return "rivage; fwd=miss";
        case Reuse::collapsed: return "rivage; fwd=miss; collapsed";
        case Reuse::hit: return "rivage; hit";
        case Reuse::bypass: return "rivage; fwd=request";
    }
    return "rivage";
}

/// Reads the request and hands the job over, or finds the one that it has made before.
Answer<std::shared_ptr<Job>> acceptJob(Exchange& exchange, JobKind kind, bool durable) {
    JobPool& pool = exchange.service.pool;
    IdempotencyKeys::Lookup known;
    const auto key = idempotencyKeyOf(exchange.request);
    if (!key) return problem(key.error());
    if (kind == JobKind::convert && !key->empty()) {
        auto lookup = pool.idempotency().claim(exchange.owner, *key);
        if (!lookup) return problem(lookup.error());
        known = *std::move(lookup);
    }
    auto request = readRequest(exchange, kind);
    if (!request) return tl::unexpected(request.error());
    request->idempotencyKey = *key;
    request->durable = durable;
    Answer<std::shared_ptr<Job>> job;
    if (known.job) {
        job = replay(exchange, known.job, *request);
    } else {
        auto* ticket = exchange.response.user_data.get<std::shared_ptr<JobPool::Ticket>>("ticket");
        auto submitted = pool.submit(std::move(**ticket), *std::move(request));
        if (!submitted) return problem(submitted.error());
        releaseUpload(exchange.response);
        job = *std::move(submitted);
        known.claim.settle(*job);
    }
    if (!job || kind != JobKind::convert) return job;
    exchange.response.set_header("Rivage-Job", (*job)->id());
    exchange.response.set_header("Cache-Status", cacheStatus((*job)->snapshot().reuse));
    return job;
}

/// Counts among those who wait for a job, as long as it lives.
class Waiting {
public:
    explicit Waiting(const std::shared_ptr<Job>& job) : job_(job) { job_->addWaiter(); }
    ~Waiting() {
        if (!left_) (void)job_->removeWaiter();
    }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;
    /// The client has left. @return whether nobody wants the job any more
    [[nodiscard]] bool leave() {
        left_ = true;
        return job_->removeWaiter();
    }

private:
    const std::shared_ptr<Job> job_;
    bool left_ = false;
};

/// Waits for the end of a job; if its last client leaves meanwhile, that cancels it.
/// @return false if the client has left
bool waitWhileWatched(Exchange& exchange, const std::shared_ptr<Job>& job,
                      Clock::time_point until) {
    Waiting waiting(job);
    while (!job->waitEnded(kPollInterval)) {
        if (clientLeft(exchange.request)) {
            if (waiting.leave()) exchange.service.pool.cancel(job);
            exchange.response.status = kClientClosed;
            return false;
        }
        if (Clock::now() >= until || (exchange.service.stopping && job->durable())) break;
    }
    return true;
}

/// 202 for a job that was not meant to outlive its request: from now on it is.
void writePromise(Exchange& exchange, const std::shared_ptr<Job>& job) {
    if (const auto kept = exchange.service.pool.keep(job); !kept) {
        exchange.service.pool.cancel(job);
        return writeError(exchange, kept.error());
    }
    writeAccepted(exchange, *job);
}

}  // namespace

Answer<void> checkSubmission(const httplib::Request& request) {
    if (const auto key = idempotencyKeyOf(request); !key) return problem(key.error());
    // The options part of a form may still complete them.
    if (formBoundary(request.get_header_value("Content-Type"))) return {};
    if (const auto options = proto::parseOptions(queryOptions(request)); !options)
        return problem(options.error());
    return {};
}

/// POST /v1/regularize -> 200 artifact | 202 job | a problem
void postRegularize(Exchange& exchange) {
    const Prefer prefer = parsePrefer(listField(exchange.request, "Prefer"));
    if (const std::string applied = prefer.applied(); !applied.empty())
        exchange.response.set_header("Preference-Applied", applied);
    const bool atOnce = prefer.wait ? prefer.wait->count() == 0 : prefer.respondAsync;
    const auto job = acceptJob(exchange, JobKind::convert, atOnce);
    if (!job) return writeProblem(exchange, job.error());

    const auto now = Clock::now();
    const auto until = atOnce ? now : prefer.wait ? now + *prefer.wait : Clock::time_point::max();
    if (!atOnce && !waitWhileWatched(exchange, *job, until)) return;
    if ((*job)->announced())
        (void)writeOutcome(exchange, **job);
    else
        writePromise(exchange, *job);
}

/// POST /v1/jobs -> 202 job + Location | a problem
void postJob(Exchange& exchange) {
    const auto job = acceptJob(exchange, JobKind::convert, true);
    if (!job) return writeProblem(exchange, job.error());
    writeAccepted(exchange, **job);
}

/// POST /v1/inspect -> 200 inspection | a problem
void postInspect(Exchange& exchange) {
    const auto job = acceptJob(exchange, JobKind::inspect, false);
    if (!job) return writeProblem(exchange, job.error());
    if (!waitWhileWatched(exchange, *job, Clock::time_point::max())) return;
    const JobSnapshot snapshot = (*job)->snapshot();
    exchange.response.set_header("Server-Timing", serverTiming(snapshot.times));
    if (snapshot.view.error) {
        proto::Problem problem = *snapshot.view.error;
        problem.instance.clear();
        return writeProblem(exchange, problem);
    }
    exchange.response.status = 200;
    writeBytes(exchange.response, snapshot.result);
}

}  // namespace rivage::server
