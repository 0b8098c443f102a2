#include "client/conversion.h"

#include <algorithm>
#include <utility>

namespace rivage::client {
namespace {

using proto::Json;
using std::chrono::milliseconds;

constexpr milliseconds kFirstPause{30};
constexpr milliseconds kLongestPause{250};
constexpr milliseconds kGiveUpPatience{2000};
constexpr const char* kLongPoll = "wait=10";  ///< seconds

tl::unexpected<Failure> notUnderstood(const std::string& what) {
    return fail(ExitCode::failed, "The server's answer is not understood", what);
}

Outcome<Json> readJob(const httplib::Response& response) {
    Json job = Json::parse(response.body, nullptr, false);
    if (!job.is_object() || textOf(job, "id").empty() || textOf(job, "state").empty())
        return notUnderstood("expected a job");
    return job;
}

/// Whether an id of the server can stand in a path as it is.
bool isPlain(const std::string& id) {
    return std::all_of(id.begin(), id.end(), [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               c == '-' || c == '_';
    });
}

/// A job that the server took and then does not know was lost by it: the input is not at fault.
Failure jobIsGone(Failure failure) {
    if (failure.exit == ExitCode::refused) failure.exit = ExitCode::failed;
    return failure;
}

JobProgress progressOf(const Json& job) {
    JobProgress progress{textOf(job, "state"), textOf(job, "stage"), numberOf(job, "progress"), {}};
    const double position = numberOf(job, "queue_position", -1);
    if (position >= 0) progress.queuePosition = position;
    return progress;
}

Outcome<std::string> submit(Transport& transport, const Upload& upload) {
    httplib::Request request = makeUpload("/v1/jobs", upload);
    request.set_header("Idempotency-Key", "\"" + randomKey() + "\"");
    const auto response = transport.send(request);
    if (!response) return tl::unexpected(response.error());
    const auto job = readJob(*response);
    if (!job) return tl::unexpected(job.error());
    std::string id = textOf(*job, "id");
    if (!isPlain(id)) return notUnderstood("the id of the job has characters that no id has");
    return id;
}

/// Waits until the job has ended; its report if it succeeded.
Outcome<Json> follow(Transport& transport, const std::string& path, const ConversionWatch& watch) {
    for (milliseconds pause = kFirstPause;; pause = std::min(pause * 3 / 2, kLongestPause)) {
        httplib::Request request = makeRequest("GET", path);
        if (!watch.lively) request.set_header("Prefer", kLongPoll);
        const auto response = transport.send(request);
        if (!response) return tl::unexpected(jobIsGone(response.error()));
        const auto job = readJob(*response);
        if (!job) return tl::unexpected(job.error());
        if (watch.progress) watch.progress(progressOf(*job));

        const std::string state = textOf(*job, "state");
        if (state == "succeeded") return job->value("report", Json::object());
        if (state == "canceled")
            return fail(ExitCode::cancelled, "The job was cancelled at the server");
        if (state == "failed")
            return tl::unexpected(failureOf(job->value("error", Json::object())));
        if (!transport.interrupt().sleep(pause)) return fail(ExitCode::cancelled, "Cancelled");
    }
}

}  // namespace

Outcome<Json> convertGrid(Transport& transport, const Upload& upload, const BodySink& sink,
                          const ConversionWatch& watch) {
    const auto id = submit(transport, upload);
    if (!id) return tl::unexpected(id.error());
    const std::string path = "/v1/jobs/" + *id;
    auto report = follow(transport, path, watch);
    if (!report) {
        const ExitCode exit = report.error().exit;
        if (exit == ExitCode::cancelled || exit == ExitCode::busy)
            transport.sendAtLast(makeRequest("DELETE", path), kGiveUpPatience);
        return report;
    }
    const auto result = transport.send(makeRequest("GET", path + "/result"), &sink);
    if (!result) return tl::unexpected(jobIsGone(result.error()));
    if (result->status != 200)
        return notUnderstood("the result of a job that succeeded has the status " +
                             std::to_string(result->status));
    return report;
}

}  // namespace rivage::client
