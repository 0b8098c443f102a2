#pragma once

#include <httplib.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace rivage::server {

/// One answered request, for the log and the metrics.
struct RequestRecord {
    std::string id;
    std::string traceId;
    std::string spanId;
    std::string parentSpan;  ///< empty if the trace began here
    std::string caller;      ///< name of the key; empty without keys
    std::string client;      ///< IP address, as a trusted proxy tells it; empty on a Unix socket
    std::string method;
    std::string route;  ///< of the table, or "-"
    int status = 0;
    std::string problem;  ///< its type, or empty
    std::string outcome;  ///< see `outcomeOf`
    double milliseconds = 0;
    double queueMs = 0;         ///< of the job that the request waited for
    double computeMs = 0;       ///< of that job, all stages
    std::uint64_t bytesIn = 0;  ///< of the body, as it was sent
    std::uint64_t bytes = 0;    ///< of the answer's body
    std::string job;
};

/// What an answer says about who failed: "ok", "client_error", "rejected" (by load or quota),
/// "timed_out", "canceled" (the client left), "engine_error" (the conversion) or "server_error".
/// @param problem  the type of the problem that was answered, or empty
/// @param ofJob    whether the request had a job
[[nodiscard]] std::string_view outcomeOf(int status, std::string_view problem, bool ofJob);

/// What there is to say about a request whose answer is written.
/// @param route  of the table, or "-": never a path that a client chose
RequestRecord recordOf(const httplib::Request& request, const httplib::Response& response,
                       std::string_view route, double milliseconds);

}  // namespace rivage::server
