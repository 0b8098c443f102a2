#include "server/http/exchange.h"

#include <algorithm>
#include <utility>

#include "server/net/canned.h"

namespace rivage::server {
namespace {

using core::ErrorCode;

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
    response.user_data.set(kProblemSlug, std::string(problem.type.slug));
    const bool received = problem.type.slug == proto::problemType(ErrorCode::keyInProgress).slug;
    if (problem.type.status == 503 || problem.type.status == 507)
        response.set_header("Retry-After", std::to_string(service.pool.retryAfter().count()));
    else if (received)
        response.set_header("Retry-After", "1");
    response.set_content(proto::writeJson(proto::toJson(problem)) + "\n", proto::kProblemMediaType);
}

void writeProblem(Exchange& exchange, const proto::Problem& problem) {
    writeProblem(exchange.service, exchange.response, problem);
}

void writeError(Exchange& exchange, const core::Error& error) {
    writeProblem(exchange, proto::makeProblem(error));
}

std::string listField(const httplib::Request& request, const std::string& name) {
    std::string list;
    for (std::size_t i = 0; i < request.get_header_value_count(name); ++i)
        list += (i > 0 ? ", " : "") + request.get_header_value(name, "", i);
    return list;
}

std::vector<std::pair<std::string, std::string>> queryOf(const httplib::Request& request) {
    std::vector<std::pair<std::string, std::string>> query;
    const std::size_t mark = request.target.find('?');
    std::string_view rest = request.target;
    rest.remove_prefix(std::min(mark == std::string::npos ? mark : mark + 1, rest.size()));
    rest = rest.substr(0, rest.find('#'));
    while (!rest.empty()) {
        const std::string_view pair = rest.substr(0, rest.find('&'));
        rest.remove_prefix(std::min(pair.size() + 1, rest.size()));
        if (pair.empty()) continue;
        const std::size_t equals = std::min(pair.find('='), pair.size());
        query.emplace_back(httplib::decode_query_component(std::string(pair.substr(0, equals))),
                           httplib::decode_query_component(
                               std::string(pair.substr(std::min(equals + 1, pair.size())))));
    }
    return query;
}

core::Result<void> checkParameters(const httplib::Request& request,
                                   const std::vector<std::string>& known) {
    std::vector<std::string> seen;
    for (const auto& [name, value] : queryOf(request)) {
        if (std::find(known.begin(), known.end(), name) == known.end())
            return core::fail(ErrorCode::malformedRequest,
                              "there is no query parameter " + proto::inQuotes(name) + " here",
                              "/query");
        if (std::find(seen.begin(), seen.end(), name) != seen.end())
            return core::fail(ErrorCode::malformedRequest, name + " is given twice",
                              "/query/" + name);
        seen.push_back(name);
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
