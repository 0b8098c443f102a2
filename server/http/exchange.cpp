#include "server/http/exchange.h"

#include <algorithm>
#include <utility>

#include "server/net/canned.h"

namespace rivage::server {
namespace {

constexpr const char* kRequestId = "X-Request-ID";

bool harmless(const std::string& id) {
    return !id.empty() && id.size() <= 64 && std::all_of(id.begin(), id.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '_' || c == '-';
    });
}

}  // namespace

void writeJson(httplib::Response& response, int status, const proto::Json& json) {
    response.status = status;
    response.set_content(proto::writeJson(json) + "\n", "application/json");
}

void writeProblem(const Service& service, httplib::Response& response,
                  const proto::Problem& problem) {
    response.status = problem.type.status;
    if (problem.type.status == 503 || problem.type.status == 507)
        response.set_header("Retry-After", std::to_string(service.pool.retryAfter().count()));
    response.set_content(proto::writeJson(proto::toJson(problem)) + "\n", proto::kProblemMediaType);
}

void writeProblem(Exchange& exchange, const proto::Problem& problem) {
    writeProblem(exchange.service, exchange.response, problem);
}

void writeError(Exchange& exchange, const core::Error& error) {
    writeProblem(exchange, proto::makeProblem(error));
}

core::Result<void> checkParameters(const httplib::Request& request,
                                   const std::vector<std::string>& known) {
    for (const auto& [name, value] : request.params) {
        if (std::find(known.begin(), known.end(), name) == known.end())
            return core::fail(core::ErrorCode::malformedRequest,
                              "there is no query parameter " + proto::inQuotes(name) + " here",
                              "/query");
        if (request.get_param_value_count(name) > 1)
            return core::fail(core::ErrorCode::malformedRequest, name + " is given twice",
                              "/query/" + name);
    }
    return {};
}

bool matchesEtag(const std::string& header, const std::string& etag) {
    if (header == "*") return true;
    for (std::size_t at = header.find(etag); at != std::string::npos;
         at = header.find(etag, at + 1)) {
        const std::size_t end = at + etag.size();
        const bool begins = at == 0 || header[at - 1] == ' ' || header[at - 1] == ',' ||
                            header[at - 1] == '\t' || header[at - 1] == '/';
        const bool ends = end == header.size() || header[end] == ',' || header[end] == ' ';
        if (begins && ends) return true;
    }
    return false;
}

std::string requestId(const httplib::Request& request, httplib::Response& response) {
    if (response.has_header(kRequestId)) return response.get_header_value(kRequestId);
    std::string id = request.get_header_value(kRequestId);
    if (!harmless(id)) id = randomRequestId();
    response.set_header(kRequestId, id);
    return id;
}

}  // namespace rivage::server
