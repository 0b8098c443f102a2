#include "server/http/routes.h"

#include <algorithm>
#include <array>

namespace rivage::server {
namespace {

constexpr std::array<Route, 17> kRoutes{{
    {"POST", "/v1/regularize", "200 202 400 408 409 413 415 422 503 504 507", postRegularize, true},
    {"POST", "/v1/jobs", "202 400 408 409 413 415 422 503 507", postJob, true},
    {"GET", "/v1/jobs", "200 400", listJobs},
    {"GET", "/v1/jobs/{id}", "200 404 410", getJob},
    {"DELETE", "/v1/jobs/{id}", "204 404 410", deleteJob},
    {"GET", "/v1/jobs/{id}/result", "200 202 206 304 400 404 409 410 413 415 416 422 504 507",
     getResult},
    {"GET", "/v1/jobs/{id}/events", "200 400 404 410 503", getEvents},
    {"GET", "/v1/jobs/{id}/preview", "200 202 304 404 410", getPreview},
    {"POST", "/v1/inspect", "200 400 408 409 413 415 422 503 504", postInspect, true},
    {"GET", "/v1/limits", "200", getLimits},
    {"GET", "/v1/formats", "200", getFormats},
    {"GET", "/v1/options", "200", getOptions},
    {"GET", "/v1/samples", "200", listSamples},
    {"GET", "/v1/samples/{name}", "200 404", getSample},
    {"GET", "/openapi.json", "200 304", getSchema},
    {"GET", "/version", "200", getVersion},
    {"GET", "/", "200 304", getIndex},
}};

/// Takes the text before the next slash off `path`.
std::string_view takeSegment(std::string_view& path) {
    const std::size_t end = std::min(path.find('/'), path.size());
    const std::string_view segment = path.substr(0, end);
    path.remove_prefix(std::min(end + 1, path.size()));
    return segment;
}

}  // namespace

std::span<const Route> routes() { return kRoutes; }

bool matchesRoute(const Route& route, std::string_view path) {
    std::string_view pattern = route.path;
    if (std::count(pattern.begin(), pattern.end(), '/') !=
        std::count(path.begin(), path.end(), '/'))
        return false;
    while (!pattern.empty() || !path.empty()) {
        const std::string_view expected = takeSegment(pattern);
        const std::string_view segment = takeSegment(path);
        const bool any = expected.starts_with('{') && !segment.empty();
        if (!any && expected != segment) return false;
    }
    return true;
}

std::string allowedMethods(std::string_view path) {
    std::string methods;
    for (const Route& route : kRoutes) {
        if (!matchesRoute(route, path)) continue;
        if (!methods.empty()) methods += ", ";
        methods += route.method == "GET" ? "GET, HEAD" : route.method;
    }
    return methods.empty() ? methods : methods + ", OPTIONS";
}

}  // namespace rivage::server
