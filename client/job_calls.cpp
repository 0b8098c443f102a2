#include "client/job_calls.h"

#include <algorithm>
#include <set>
#include <utility>

namespace rivage::client {
namespace {

using proto::Json;
using std::chrono::milliseconds;

constexpr milliseconds kFirstPause{30};
constexpr milliseconds kLongestPause{250};
constexpr const char* kLongPoll = "wait=10";  ///< seconds
constexpr std::size_t kPage = 100;
constexpr std::size_t kMostJobs = 1'000'000;  ///< more than any server keeps
constexpr SendOptions kPatient{.sink = nullptr, .patient = true};

tl::unexpected<Failure> notUnderstood(const std::string& what) {
    return fail(ExitCode::failed, "The server's answer is not understood", what);
}

Outcome<Json> readJob(const httplib::Response& response) {
    Json job = readAnswer(response.body);
    if (textOf(job, "id").empty() || textOf(job, "state").empty())
        return notUnderstood("expected a job");
    return job;
}

std::optional<double> numberIn(const Json& object, const char* name) {
    const auto member = object.find(name);
    if (member == object.end() || !member->is_number()) return std::nullopt;
    return member->get<double>();
}

std::string pathOf(const std::string& id) { return "/v1/jobs/" + id; }

bool hasEnded(const Json& job) {
    const std::string state = textOf(job, "state");
    return state == "succeeded" || state == "failed" || state == "canceled";
}

}  // namespace

bool isJobId(const std::string& text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               c == '-' || c == '_';
    });
}

JobProgress progressOf(const Json& job) {
    return {.state = textOf(job, "state"),
            .stage = textOf(job, "stage"),
            .fraction = numberOf(job, "progress"),
            .queuePosition = numberIn(job, "queue_position"),
            .energy = numberIn(job, "energy"),
            .step = numberIn(job, "step")};
}

Outcome<std::string> submitJob(Transport& transport, const Upload& upload) {
    httplib::Request request = makeUpload("/v1/jobs", upload);
    request.set_header("Idempotency-Key", "\"" + randomKey() + "\"");
    const auto response = transport.send(request);
    if (!response) return tl::unexpected(response.error());
    const auto job = readJob(*response);
    if (!job) return tl::unexpected(job.error());
    std::string id = textOf(*job, "id");
    if (!isJobId(id)) return notUnderstood("the id of the job has characters that no id has");
    return id;
}

Outcome<Json> getJob(Transport& transport, const std::string& id) {
    const auto response = transport.send(makeRequest("GET", pathOf(id)), kPatient);
    if (!response) return tl::unexpected(response.error());
    return readJob(*response);
}

Outcome<Json> followJob(Transport& transport, const std::string& id, const JobWatch& watch) {
    for (milliseconds pause = kFirstPause;; pause = std::min(pause * 3 / 2, kLongestPause)) {
        httplib::Request request = makeRequest("GET", pathOf(id));
        if (!watch.lively) request.set_header("Prefer", kLongPoll);
        const auto response = transport.send(request, kPatient);
        if (!response) return tl::unexpected(response.error());
        auto job = readJob(*response);
        if (!job) return job;
        if (watch.progress) watch.progress(progressOf(*job));
        if (hasEnded(*job)) return job;
        if (!transport.interrupt().sleep(pause)) return fail(ExitCode::cancelled, "Cancelled");
    }
}

Outcome<Json> reportOf(const Json& job) {
    const std::string state = textOf(job, "state");
    if (state == "canceled")
        return fail(ExitCode::cancelled, "The job was cancelled at the server");
    if (state == "failed") return tl::unexpected(failureOf(job.value("error", Json::object())));
    Json report = job.value("report", Json::object());
    if (!report.is_object()) return notUnderstood("expected the report of a job");
    return report;
}

Outcome<void> fetchResult(Transport& transport, const std::string& id, const ByteStore& store) {
    return download(transport, pathOf(id) + "/result", store, true);
}

Outcome<std::vector<Json>> listJobs(Transport& transport, const JobQuery& query) {
    const std::size_t most = query.limit == 0 ? ~std::size_t{0} : query.limit;
    std::vector<Json> jobs;
    std::string path = "/v1/jobs?limit=" + std::to_string(std::min(most, kPage));
    if (!query.state.empty()) path += "&state=" + query.state;
    std::set<std::string> asked;
    while (!path.empty()) {
        if (!asked.insert(path).second) return notUnderstood("a list of jobs that goes in circles");
        const auto response = transport.send(makeRequest("GET", path));
        if (!response) return tl::unexpected(response.error());
        const Json page = readAnswer(response->body);
        if (!page.contains("jobs") || !page["jobs"].is_array())
            return notUnderstood("expected a list of jobs");
        for (const Json& job : page["jobs"])
            if (job.is_object() && jobs.size() < most) jobs.push_back(job);
        if (jobs.size() > kMostJobs) return notUnderstood("a list of jobs without an end");
        path = jobs.size() < most && !page["jobs"].empty() ? textOf(page, "next") : std::string();
        if (!path.empty() && !path.starts_with("/v1/jobs?")) return notUnderstood("a foreign link");
    }
    return jobs;
}

httplib::Request makeDeletion(const std::string& id) { return makeRequest("DELETE", pathOf(id)); }

}  // namespace rivage::client
