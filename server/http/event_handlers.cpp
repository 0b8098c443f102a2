#include <charconv>

#include "server/http/held_place.h"
#include "server/http/job_answers.h"
#include "server/http/routes.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using namespace std::chrono_literals;

/// A stream looks so often whether the server stops.
constexpr std::chrono::milliseconds kPollInterval{250};
/// What keeps proxies from closing a silent stream.
constexpr std::chrono::seconds kHeartbeat{10};

/// The events of one job, as they are sent to one client.
class EventStream {
public:
    EventStream(Service& service, std::shared_ptr<Job> job, std::uint64_t after)
        : service_(service),
          place_(service.streaming, service.streams),
          job_(std::move(job)),
          last_(after) {}

    [[nodiscard]] bool held() const { return place_.held(); }

    /// Sends what there is; waits for it. @return false if the client has left
    bool send(httplib::DataSink& sink) {
        const bool over = job_->announced();
        const auto events = job_->waitEvents(last_, over ? 0ms : kPollInterval);
        std::string text = std::exchange(opening_, {});
        for (const JobEvent& event : events) append(text, event);
        if (over) {
            append(text,
                   {last_ + 1, "done", proto::writeJson(proto::toJson(service_.pool.view(*job_)))});
        } else if (text.empty() && Clock::now() - lastSent_ >= kHeartbeat) {
            text = ": still there\n\n";
        }
        if (!text.empty()) {
            if (!sink.write(text.data(), text.size())) return false;
            lastSent_ = Clock::now();
        }
        if (over || service_.stopping) sink.done();
        return true;
    }

private:
    void append(std::string& text, const JobEvent& event) {
        text += "id: " + std::to_string(event.id) + "\nevent: " + event.name +
                "\ndata: " + event.data + "\n\n";
        last_ = event.id;
    }

    Service& service_;
    const HeldPlace place_;
    const std::shared_ptr<Job> job_;
    std::uint64_t last_;
    std::string opening_ = "retry: 1000\n\n";
    Clock::time_point lastSent_ = Clock::now();
};

/// After which event to begin, by Last-Event-ID or by the query.
core::Result<std::uint64_t> readLastEvent(const httplib::Request& request) {
    if (const auto known = checkParameters(request, {"after"}); !known)
        return core::fail(known.error());
    const bool header = request.has_header("Last-Event-ID");
    const std::string text =
        header ? request.get_header_value("Last-Event-ID") : request.get_param_value("after");
    std::uint64_t id = 0;
    if (text.empty()) return id;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
    if (error != std::errc() || end != text.data() + text.size())
        return core::fail(ErrorCode::malformedRequest, "the id of an event is a whole number",
                          header ? "/headers/last-event-id" : "/query/after");
    return id;
}

}  // namespace

/// GET /v1/jobs/{id}/events -> 200 events | 400 | 404 | 410 | 503
void getEvents(Exchange& exchange) {
    const auto job = findJob(exchange);
    if (!job) return writeError(exchange, job.error());
    const auto after = readLastEvent(exchange.request);
    if (!after) return writeError(exchange, after.error());
    const auto stream = std::make_shared<EventStream>(exchange.service, *job, *after);
    if (!stream->held()) {
        core::Error error{ErrorCode::busy, "too many clients follow the events of jobs"};
        error.limit = exchange.service.streams;
        error.setting = "--streams";
        return writeError(exchange, error);
    }
    exchange.response.set_header("Cache-Control", "no-store");
    exchange.response.set_header("X-Accel-Buffering", "no");  // nginx passes events on at once
    exchange.response.status = 200;
    exchange.response.set_chunked_content_provider(
        "text/event-stream",
        [stream](std::size_t, httplib::DataSink& sink) { return stream->send(sink); });
}

/// GET /v1/jobs/{id}/preview -> 200 the newest intermediate surface | 202 not yet | 304 | 404 | 410
void getPreview(Exchange& exchange) {
    const auto job = findJob(exchange);
    if (!job) return writeError(exchange, job.error());
    if (!(*job)->facts().progressive)
        return writeError(exchange, {ErrorCode::notFound,
                                     "this job has no previews: it was not asked for with "
                                     "progressive=true",
                                     "/options/progressive"});
    if (proto::hasEnded((*job)->state()))
        return writeError(exchange,
                          {ErrorCode::expired, "the job has ended: its result is the surface"});
    const auto preview = (*job)->preview();
    if (!preview) return writeAccepted(exchange, **job);

    httplib::Response& response = exchange.response;
    response.set_header("ETag", preview->surface->etag);
    response.set_header("Cache-Control", "no-store");
    response.set_header("Rivage-Preview-Step", std::to_string(preview->step));
    if (matchesEtag(listField(exchange.request, "If-None-Match"), preview->surface->etag)) {
        response.status = 304;
        return;
    }
    response.status = 200;
    writeBytes(response, preview->surface);
}

}  // namespace rivage::server
