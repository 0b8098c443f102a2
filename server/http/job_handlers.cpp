#include <algorithm>
#include <charconv>
#include <cstdio>
#include <utility>

#include "server/http/prefer.h"
#include "server/http/routes.h"
#include "server/http/upload.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using proto::JobState;

/// How often a waiting request looks whether its client is still there.
constexpr std::chrono::milliseconds kPollInterval{50};
constexpr std::size_t kMaxListed = 500;

proto::Problem jobProblem(const JobSnapshot& job) {
    if (job.view.error) return *job.view.error;
    return proto::makeProblem({ErrorCode::expired, "the result of this job is no longer kept"});
}

/// `queue;dur=0.1, parse;dur=12.3, ...`, milliseconds.
std::string serverTiming(const JobTimes& times) {
    char text[64];
    std::snprintf(text, sizeof text, "queue;dur=%.3f", times.queue);
    std::string value = text;
    for (std::size_t i = 0; i < core::kStageCount; ++i) {
        std::snprintf(text, sizeof text, ", %s;dur=%.3f",
                      core::stageName(static_cast<core::Stage>(i)), times.stages[i]);
        value += text;
    }
    return value;
}

/// Query parameters are options, whatever their name.
std::vector<proto::OptionText> queryOptions(const httplib::Request& request) {
    std::vector<proto::OptionText> options;
    for (const auto& [name, value] : request.params) options.push_back({name, value});
    return options;
}

/// Reads the request and hands the job over. What can be refused before the body is read, is.
Answer<std::shared_ptr<Job>> acceptJob(Exchange& exchange, JobKind kind) {
    const auto query = queryOptions(exchange.request);
    const bool form = exchange.request.is_multipart_form_data();
    auto options = form ? proto::JobOptions{} : proto::parseOptions(query);
    if (!options) return problem(options.error());

    auto upload = readUpload(exchange);
    if (!upload) return tl::unexpected(upload.error());
    if (form) options = proto::parseOptions(query, upload->options);
    if (!options) return problem(options.error());

    JobRequest request{kind, std::move(upload->grid), *std::move(options)};
    if (!upload->name.empty()) request.name = std::move(upload->name);
    request.requestId = exchange.response.get_header_value("X-Request-ID");
    auto* ticket = exchange.response.user_data.get<std::shared_ptr<JobPool::Ticket>>("ticket");
    auto job = exchange.service.pool.submit(std::move(**ticket), std::move(request));
    if (!job) return problem(job.error());
    if (kind == JobKind::convert) exchange.response.set_header("Rivage-Job", (*job)->id());
    return *std::move(job);
}

/// Waits for the end of a job; a client that leaves meanwhile cancels it.
/// @return false if the client has left
bool waitWhileWatched(Exchange& exchange, const std::shared_ptr<Job>& job,
                      Clock::time_point until) {
    while (!job->waitEnded(kPollInterval)) {
        if (exchange.request.is_connection_closed()) {
            exchange.service.pool.cancel(job);
            exchange.response.status = kClientClosed;
            return false;
        }
        if (Clock::now() >= until) break;
    }
    return true;
}

void writeJob(Exchange& exchange, int status, const Job& job) {
    const proto::JobView view = exchange.service.pool.view(job);
    if (status == 202 || !proto::hasEnded(view.state))
        exchange.response.set_header("Retry-After",
                                     std::to_string(exchange.service.pool.retryAfter().count()));
    writeJson(exchange.response, status, proto::toJson(view));
}

void writeAccepted(Exchange& exchange, const Job& job) {
    exchange.response.set_header("Location", "/v1/jobs/" + job.id());
    writeJob(exchange, 202, job);
}

/// The bytes of a result, without copying them.
void writeBytes(Exchange& exchange, const std::shared_ptr<const JobResult>& result) {
    exchange.response.set_content_provider(
        result->bytes.size(), result->mediaType,
        [result](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
            return sink.write(reinterpret_cast<const char*>(result->bytes.data()) + offset, length);
        });
}

/// The answer of a job that has ended, in the request that asked for it.
void writeOutcome(Exchange& exchange, const JobSnapshot& job) {
    httplib::Response& response = exchange.response;
    response.set_header("Server-Timing", serverTiming(job.times));
    if (!job.result) return writeProblem(exchange, jobProblem(job));
    response.set_header("Content-Disposition",
                        "attachment; filename=\"" + job.result->fileName + "\"");
    response.set_header("ETag", job.result->etag);
    response.set_header("Repr-Digest", job.result->reprDigest);
    response.status = 200;
    writeBytes(exchange, job.result);
}

/// Holds one of the places of waiting GETs, if there is one left.
class LongPoll {
public:
    explicit LongPoll(Service& service)
        : service_(service), held_(service.waiting++ < service.longPolls) {}
    ~LongPoll() { --service_.waiting; }
    LongPoll(const LongPoll&) = delete;
    LongPoll& operator=(const LongPoll&) = delete;
    [[nodiscard]] bool held() const { return held_ && !service_.stopping; }

private:
    Service& service_;
    const bool held_;
};

core::Result<JobQuery> readJobQuery(const httplib::Request& request) {
    if (const auto known = checkParameters(request, {"state", "after", "limit"}); !known)
        return core::fail(known.error());
    JobQuery query;
    query.after = request.get_param_value("after");
    if (request.has_param("state")) {
        query.state = proto::stateFromName(request.get_param_value("state"));
        if (!query.state)
            return core::fail(ErrorCode::malformedRequest,
                              "state must be queued, running, succeeded, failed or canceled",
                              "/query/state");
    }
    if (request.has_param("limit")) {
        const std::string text = request.get_param_value("limit");
        const auto [end, error] =
            std::from_chars(text.data(), text.data() + text.size(), query.limit);
        if (error != std::errc() || end != text.data() + text.size() || query.limit == 0 ||
            query.limit > kMaxListed)
            return core::fail(ErrorCode::malformedRequest, "limit must be an integer from 1 to 500",
                              "/query/limit");
    }
    return query;
}

core::Result<std::shared_ptr<Job>> findJob(Exchange& exchange) {
    const std::string& id = exchange.request.path_params.at("id");
    if (!looksLikeUuid(id)) return core::fail(ErrorCode::notFound, "this is no job id", "/id");
    return exchange.service.pool.find(id);
}

}  // namespace

/// POST /v1/regularize -> 200 artifact | 202 job | 400 | 408 | 409 | 413 | 415 | 422 | 503 | 504
void postRegularize(Exchange& exchange) {
    const Prefer prefer = parsePrefer(exchange.request.get_header_value("Prefer"));
    if (const std::string applied = prefer.applied(); !applied.empty())
        exchange.response.set_header("Preference-Applied", applied);
    const auto job = acceptJob(exchange, JobKind::convert);
    if (!job) return writeProblem(exchange, job.error());

    const auto now = Clock::now();
    auto until = prefer.wait ? now + *prefer.wait : Clock::time_point::max();
    if (prefer.respondAsync && !prefer.wait) until = now;
    if (until > now && !waitWhileWatched(exchange, *job, until)) return;
    if (!proto::hasEnded((*job)->state())) return writeAccepted(exchange, **job);
    writeOutcome(exchange, (*job)->snapshot());
}

/// POST /v1/jobs -> 202 job + Location | 400 | 408 | 413 | 415 | 503
void postJob(Exchange& exchange) {
    const auto job = acceptJob(exchange, JobKind::convert);
    if (!job) return writeProblem(exchange, job.error());
    writeAccepted(exchange, **job);
}

/// POST /v1/inspect -> 200 inspection | 400 | 408 | 409 | 413 | 415 | 422 | 503 | 504
void postInspect(Exchange& exchange) {
    const auto job = acceptJob(exchange, JobKind::inspect);
    if (!job) return writeProblem(exchange, job.error());
    if (!waitWhileWatched(exchange, *job, Clock::time_point::max())) return;
    const JobSnapshot snapshot = (*job)->snapshot();
    exchange.response.set_header("Server-Timing", serverTiming(snapshot.times));
    if (!snapshot.result) {
        proto::Problem problem = jobProblem(snapshot);
        problem.instance.clear();
        return writeProblem(exchange, problem);
    }
    exchange.response.status = 200;
    writeBytes(exchange, snapshot.result);
}

/// GET /v1/jobs?state=&after=&limit= -> 200 {jobs, next} | 400
void listJobs(Exchange& exchange) {
    const auto query = readJobQuery(exchange.request);
    if (!query) return writeError(exchange, query.error());
    proto::Json jobs = proto::Json::array();
    const auto found = exchange.service.pool.list(*query);
    for (const auto& job : found) jobs.push_back(proto::toJson(exchange.service.pool.view(*job)));
    proto::Json next;
    if (found.size() == query->limit) {
        std::string link = "/v1/jobs?limit=" + std::to_string(query->limit);
        if (query->state) link += std::string("&state=") + proto::stateName(*query->state);
        next = link + "&after=" + found.back()->id();
    }
    writeJson(exchange.response, 200, {{"jobs", std::move(jobs)}, {"next", std::move(next)}});
}

/// GET /v1/jobs/{id} -> 200 job | 404 | 410; `Prefer: wait=N` waits for its end
void getJob(Exchange& exchange) {
    const auto job = findJob(exchange);
    if (!job) return writeError(exchange, job.error());
    const Prefer prefer = parsePrefer(exchange.request.get_header_value("Prefer"));
    if (prefer.wait) {
        exchange.response.set_header("Preference-Applied",
                                     "wait=" + std::to_string(prefer.wait->count()));
        const LongPoll poll(exchange.service);
        const auto until = Clock::now() + *prefer.wait;
        while (poll.held() && Clock::now() < until && !(*job)->waitEnded(kPollInterval) &&
               !exchange.request.is_connection_closed()) {
        }
    }
    writeJob(exchange, 200, **job);
}

/// GET /v1/jobs/{id}/result -> 200 | 206 | 304 | 202 while it runs | its problem | 404 | 410
void getResult(Exchange& exchange) {
    const auto job = findJob(exchange);
    if (!job) return writeError(exchange, job.error());
    const JobSnapshot snapshot = (*job)->snapshot();
    if (!proto::hasEnded(snapshot.view.state)) return writeAccepted(exchange, **job);
    writeOutcome(exchange, snapshot);
    if (!snapshot.result) return;

    const httplib::Request& request = exchange.request;
    httplib::Response& response = exchange.response;
    const std::string& etag = snapshot.result->etag;
    response.set_header("Accept-Ranges", "bytes");
    response.set_header("Cache-Control", "private, max-age=31536000, immutable");
    if (matchesEtag(request.get_header_value("If-None-Match"), etag)) {
        response.status = 304;
        response.set_header("Content-Length", std::to_string(snapshot.result->bytes.size()));
        response.content_provider_ = nullptr;
        response.content_length_ = 0;
        return;
    }
    // Without a status, the library answers 206 to a Range; If-Range may forbid it.
    const std::string ifRange = request.get_header_value("If-Range");
    if (ifRange.empty() || ifRange == etag) response.status = -1;
}

/// DELETE /v1/jobs/{id} -> 204: cancels a job, or forgets one that has ended | 404 | 410
void deleteJob(Exchange& exchange) {
    const auto job = findJob(exchange);
    if (!job) return writeError(exchange, job.error());
    if (proto::hasEnded((*job)->state()))
        exchange.service.pool.forget(**job);
    else
        exchange.service.pool.cancel(*job);
    exchange.response.status = 204;
}

}  // namespace rivage::server
