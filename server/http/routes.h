#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/exchange.h"

namespace rivage::server {

/// One line of the table of routes, which server/README.md repeats and a test compares.
struct Route {
    std::string_view method;
    std::string_view path;  ///< segments in braces match anything
    std::string_view
        statuses;  ///< of the handler itself; /v1/ may also answer 401, 403, 429, all 404, 405, 500
    void (*handle)(Exchange&);
    bool upload = false;  ///< takes a grid, so it needs a place in the queue before its body
};

[[nodiscard]] std::span<const Route> routes();

/// Whether a request path has the form of a route's path.
[[nodiscard]] bool matchesRoute(const Route& route, std::string_view path);

/// The methods that a path takes, for `Allow`; empty if there is no such path.
[[nodiscard]] std::string allowedMethods(std::string_view path);

/// What can be said about a new job before its body: options in the query, the idempotency key.
/// @errors as parseOptions; malformedRequest
Answer<void> checkSubmission(const httplib::Request& request);

// POST /v1/regularize, /v1/jobs, /v1/inspect
void postRegularize(Exchange& exchange);
void postJob(Exchange& exchange);
void postInspect(Exchange& exchange);
// /v1/jobs...
void listJobs(Exchange& exchange);
void getJob(Exchange& exchange);
void getResult(Exchange& exchange);
void deleteJob(Exchange& exchange);
void getEvents(Exchange& exchange);
void getPreview(Exchange& exchange);
// What the server is and can do
void getLimits(Exchange& exchange);
void getFormats(Exchange& exchange);
void getOptions(Exchange& exchange);
void listSamples(Exchange& exchange);
void getSample(Exchange& exchange);
void getSchema(Exchange& exchange);
void getVersion(Exchange& exchange);
void getIndex(Exchange& exchange);

/// Answers with a file that is built in; honours If-None-Match.
void writeAsset(const httplib::Request& request, httplib::Response& response,
                const WebAsset& asset);

}  // namespace rivage::server
