#include <charconv>
#include <utility>

#include "server/http/held_place.h"
#include "server/http/job_answers.h"
#include "server/http/prefer.h"
#include "server/http/routes.h"
#include "server/net/answer.h"

namespace rivage::server {
namespace {

using core::ErrorCode;

/// How often a waiting request looks whether its client is still there.
constexpr std::chrono::milliseconds kPollInterval{50};
constexpr std::size_t kMaxListed = 500;
constexpr std::size_t kMaxRanges = 16;

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

/// 304, or what the conditions and ranges of a request leave of a whole result.
void applyConditions(Exchange& exchange, const JobResult& result) {
    const httplib::Request& request = exchange.request;
    httplib::Response& response = exchange.response;
    if (matchesEtag(listField(request, "If-None-Match"), result.etag)) {
        response.status = 304;
        response.headers.erase("Content-Digest");
        response.set_header("Content-Length", std::to_string(result.size()));
        response.content_provider_ = nullptr;
        response.content_length_ = 0;
        return;
    }
    const std::string ifRange = request.get_header_value("If-Range");
    if (request.ranges.empty() || (!ifRange.empty() && ifRange != result.etag)) return;
    // More than there is from the end is all of it, which the library takes for an error. The
    // request is an object that is not const; only handlers see it so.
    const auto size = static_cast<ssize_t>(result.size());
    for (auto& [begin, end] : const_cast<httplib::Request&>(request).ranges)
        if (begin == -1 && end > size) end = size;
    // Without a status, the library answers 206 to a Range.
    response.headers.erase("Content-Digest");
    response.status = -1;
}

}  // namespace

/// GET /v1/jobs?state=&after=&limit= -> 200 {jobs, next} | 400
void listJobs(Exchange& exchange) {
    auto query = readJobQuery(exchange.request);
    if (!query) return writeError(exchange, query.error());
    query->owner = exchange.owner;
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
    Service& service = exchange.service;
    const Prefer prefer = parsePrefer(listField(exchange.request, "Prefer"));
    if (prefer.wait) {
        exchange.response.set_header("Preference-Applied",
                                     "wait=" + std::to_string(prefer.wait->count()));
        const HeldPlace place(service.waiting, service.longPolls);
        const auto until = Clock::now() + *prefer.wait;
        while (place.held() && !service.stopping && Clock::now() < until &&
               !(*job)->waitEnded(kPollInterval) && !clientLeft(exchange.request)) {
        }
    }
    writeJob(exchange, 200, **job);
}

/// GET /v1/jobs/{id}/result -> 200 | 206 | 304 | 202 while it runs | its problem | 404 | 410
void getResult(Exchange& exchange) {
    const auto job = findJob(exchange);
    if (!job) return writeError(exchange, job.error());
    if (!proto::hasEnded((*job)->state())) return writeAccepted(exchange, **job);
    const std::size_t ranges = exchange.request.ranges.size();
    if (ranges > kMaxRanges && (*job)->state() == proto::JobState::succeeded)
        return writeProblem(exchange,
                            {proto::transportProblemType(416), "too many ranges in one request",
                             "/headers/range", kMaxRanges, ranges});
    const ResultPtr result = writeOutcome(exchange, **job);
    if (!result) return;
    exchange.response.set_header("Accept-Ranges", "bytes");
    exchange.response.set_header("Cache-Control", "private, max-age=31536000, immutable");
    applyConditions(exchange, *result);
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
