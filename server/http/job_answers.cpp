#include "server/http/job_answers.h"

#include <cstdio>

#include "server/net/answer.h"

namespace rivage::server {

core::Result<std::shared_ptr<Job>> findJob(Exchange& exchange) {
    const std::string& id = exchange.request.path_params.at("id");
    if (!looksLikeUuid(id))
        return core::fail(core::ErrorCode::notFound, "this is no job id", "/id");
    return exchange.service.pool.find(exchange.owner, id);
}

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

void writeBytes(httplib::Response& response, const ResultPtr& result) {
    lendBytes(response, result, result->blob->bytes());
    response.set_content_provider(
        result->size(), result->mediaType,
        [result](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
            const auto bytes = result->blob->bytes();
            return sink.write(reinterpret_cast<const char*>(bytes.data()) + offset, length);
        });
}

ResultPtr writeOutcome(Exchange& exchange, Job& job) {
    httplib::Response& response = exchange.response;
    const JobSnapshot snapshot = job.snapshot();
    response.set_header("Server-Timing", serverTiming(snapshot.times));
    if (snapshot.view.error) {
        writeProblem(exchange, *snapshot.view.error);
        return nullptr;
    }
    const auto result = exchange.service.pool.result(job);
    if (!result) {
        writeError(exchange, result.error());
        return nullptr;
    }
    response.set_header("Content-Disposition", "attachment; filename=\"" + job.facts().name + "." +
                                                   (*result)->extension + "\"");
    response.set_header("ETag", (*result)->etag);
    response.set_header("Repr-Digest", (*result)->reprDigest);
    response.set_header("Content-Digest", (*result)->reprDigest);
    response.status = 200;
    writeBytes(response, *result);
    return *result;
}

}  // namespace rivage::server
