#pragma once

#include <httplib.h>

#include <string>
#include <utility>
#include <vector>

#include "proto/problem.h"
#include "server/http/service.h"

namespace rivage::server {

/// One request with the answer to it, as handlers see them.
struct Exchange {
    const httplib::Request& request;
    httplib::Response& response;
    const httplib::ContentReader* body;  ///< of routes that take an upload, else null
    Service& service;
    std::string owner = {};        ///< name of who calls; of the jobs that this request may see
    std::string traceparent = {};  ///< for the jobs that this request starts
};

/// What a step of a handler gives, or the problem to answer with.
template <typename T>
using Answer = tl::expected<T, proto::Problem>;
[[nodiscard]] inline tl::unexpected<proto::Problem> problem(const core::Error& error) {
    return tl::unexpected<proto::Problem>(proto::makeProblem(error));
}

/// The status that the log shows for a client that left before its answer.
inline constexpr int kClientClosed = 499;

/// Where the type of the problem that was answered, and the bytes of the body that came, are kept
/// with the response.
inline constexpr const char* kProblemSlug = "problem";
inline constexpr const char* kBytesIn = "bytes-in";

void writeJson(httplib::Response& response, int status, const proto::Json& json);

/// Answers with a problem; those that time heals say when to come back.
void writeProblem(const Service& service, httplib::Response& response,
                  const proto::Problem& problem);
void writeProblem(Exchange& exchange, const proto::Problem& problem);
void writeError(Exchange& exchange, const core::Error& error);

/// The value of a header that is a list, from all fields of its name.
[[nodiscard]] std::string listField(const httplib::Request& request, const std::string& name);

/// The query parameters as they were sent, also those that are sent twice.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> queryOf(
    const httplib::Request& request);

/// Refuses query parameters that the route does not know: nothing is ignored in silence.
/// @errors malformedRequest
core::Result<void> checkParameters(const httplib::Request& request,
                                   const std::vector<std::string>& known);

/// Whether one of the entity tags of If-None-Match is `etag`, or it is "*".
[[nodiscard]] bool matchesEtag(const std::string& header, const std::string& etag);

/// Takes the client's request id if it is harmless, else makes one. Kept in the answer's header.
std::string requestId(const httplib::Request& request, httplib::Response& response);

}  // namespace rivage::server
