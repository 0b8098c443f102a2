#include "server/http/cors.h"

#include <algorithm>

namespace rivage::server {
namespace {

constexpr const char* kAllowOrigin = "Access-Control-Allow-Origin";

/// Every header field that the interface reads, beyond those that pages may always send.
constexpr const char* kRequestHeaders =
    "Authorization, Cache-Control, Content-Digest, Content-Disposition, Content-Encoding, "
    "Content-Type, Idempotency-Key, If-None-Match, If-Range, Last-Event-ID, Prefer, Range, "
    "Repr-Digest, X-API-Key, X-Request-ID, traceparent";

/// Every header field that the interface sets, beyond those that pages may always read.
constexpr const char* kResponseHeaders =
    "Accept-Ranges, Allow, Cache-Status, Content-Digest, Content-Disposition, Content-Range, ETag, "
    "Idempotent-Replayed, Location, Preference-Applied, RateLimit, RateLimit-Policy, Repr-Digest, "
    "Retry-After, Rivage-Job, Rivage-Preview-Step, Server-Timing, WWW-Authenticate, X-Request-ID";

}  // namespace

void allowOrigin(const std::vector<std::string>& origins, const httplib::Request& request,
                 httplib::Response& response) {
    if (origins.empty() || response.has_header("Vary")) return;
    response.set_header("Vary", "Origin");
    const std::string origin = request.get_header_value("Origin");
    if (std::find(origins.begin(), origins.end(), origin) == origins.end()) return;
    response.set_header(kAllowOrigin, origin);
    response.set_header("Access-Control-Expose-Headers", kResponseHeaders);
}

bool isPreflight(const std::vector<std::string>& origins, const httplib::Request& request) {
    return !origins.empty() && request.method == "OPTIONS" && request.has_header("Origin") &&
           request.has_header("Access-Control-Request-Method");
}

void writePreflight(const std::string& methods, httplib::Response& response) {
    response.status = 204;
    if (!response.has_header(kAllowOrigin)) return;
    response.headers.erase("Access-Control-Expose-Headers");
    response.set_header("Access-Control-Allow-Methods", methods);
    response.set_header("Access-Control-Allow-Headers", kRequestHeaders);
    response.set_header("Access-Control-Max-Age", "600");
}

}  // namespace rivage::server
