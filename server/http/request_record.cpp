#include "server/http/request_record.h"

#include <charconv>

#include "server/http/access.h"
#include "server/http/exchange.h"
#include "server/http/trace.h"

namespace rivage::server {
namespace {

/// Reads "queue;dur=0.1, parse;dur=12.3, ..." as `Server-Timing` has it.
void readTimes(std::string_view header, RequestRecord& record) {
    constexpr std::string_view kMark = ";dur=";
    const bool queueFirst = header.starts_with("queue;");
    for (bool first = true;; first = false) {
        const std::size_t at = header.find(kMark);
        if (at == std::string_view::npos) return;
        header.remove_prefix(at + kMark.size());
        double value = 0;
        std::from_chars(header.data(), header.data() + header.size(), value);
        (first && queueFirst ? record.queueMs : record.computeMs) += value;
    }
}

}  // namespace

std::string_view outcomeOf(int status, std::string_view problem, bool ofJob) {
    if (status == kClientClosed) return "canceled";
    if (status < 400) return "ok";
    if (status == 408 || problem == "deadline-exceeded") return "timed_out";
    if (status == 429 || status == 503 || status == 507) return "rejected";
    if (problem == "not-converged" || problem == "poison") return "engine_error";
    if (status < 500) return "client_error";
    return ofJob ? "engine_error" : "server_error";
}

RequestRecord recordOf(const httplib::Request& request, const httplib::Response& response,
                       std::string_view route, double milliseconds) {
    const Trace& trace = traceOf(response);
    const auto* problem = response.user_data.get<std::string>(kProblemSlug);
    const auto* received = response.user_data.get<std::uint64_t>(kBytesIn);
    RequestRecord record;
    record.id = response.get_header_value("X-Request-ID");
    record.traceId = trace.traceId;
    record.spanId = trace.spanId;
    record.parentSpan = trace.parentId;
    record.caller = callerOf(response).name;
    record.client = request.remote_addr;
    record.method = request.method;
    record.route = route;
    record.status = response.status;
    if (problem && response.status >= 400) record.problem = *problem;
    record.milliseconds = milliseconds;
    readTimes(response.get_header_value("Server-Timing"), record);
    record.bytesIn = received ? *received : request.body.size();
    record.bytes = response.body.empty() ? response.content_length_ : response.body.size();
    record.job = response.get_header_value("Rivage-Job");
    record.outcome = outcomeOf(record.status, record.problem, !record.job.empty());
    return record;
}

}  // namespace rivage::server
