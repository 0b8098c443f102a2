#include "server/http/http_server.h"

#include <memory>
#include <utility>

#include "server/http/access.h"
#include "server/http/cors.h"
#include "server/http/exchange.h"
#include "server/http/routes.h"
#include "server/http/text.h"
#include "server/http/trace.h"
#include "server/http/upload.h"
#include "server/net/answer.h"

namespace rivage::server {
namespace {

using core::ErrorCode;

/// What a body may have beyond the grid: the frame of a form and its options.
constexpr std::size_t kBodyOverhead = 1 << 20;

/// The pattern of cpp-httplib for a path of ours: "{id}" becomes ":id".
std::string libraryPattern(std::string_view path) {
    std::string pattern;
    for (const char c : path)
        if (c == '{')
            pattern += ':';
        else if (c != '}')
            pattern += c;
    return pattern;
}

const WebAsset* findAsset(std::span<const WebAsset> assets, const std::string& path) {
    for (const WebAsset& asset : assets)
        if (asset.path == path) return &asset;
    return nullptr;
}

bool expectsTheUnknown(const httplib::Request& request) {
    const std::string expectation = lowerCase(request.get_header_value("Expect"));
    return !expectation.empty() && expectation != "100-continue";
}

const Route* findRoute(const std::string& method, const std::string& path) {
    for (const Route& route : routes()) {
        const bool head = method == "HEAD" && route.method == "GET";
        if ((head || route.method == method) && matchesRoute(route, path)) return &route;
    }
    return nullptr;
}

}  // namespace

HttpServer::HttpServer(HttpSettings settings, Service& service)
    : settings_(std::move(settings)),
      service_(service),
      front_(settings_.net, server_, [this](int status, const std::string& id) {
          if (!settings_.observer) return;
          RequestRecord record;
          record.id = id;
          record.method = record.route = "-";
          record.status = status;
          record.problem = proto::transportProblemType(status).slug;
          record.outcome = outcomeOf(status, record.problem, false);
          settings_.observer(record);
      }) {
    setLimits();
    setHooks();
    setRoutes();
}

HttpServer::~HttpServer() { stop(); }

void HttpServer::setLimits() {
    server_.set_keep_alive_timeout(
        std::chrono::ceil<std::chrono::seconds>(settings_.net.idleTimeout).count());
    server_.set_keep_alive_max_count(settings_.net.requestsPerConnection);
    server_.set_payload_max_length(service_.limits.maxUploadBytes + kBodyOverhead);
    server_.set_default_headers({{"X-Content-Type-Options", "nosniff"}});
    server_.set_trusted_proxies(settings_.trustedProxies);
}

void HttpServer::setHooks() {
    server_.set_expect_100_continue_handler(
        [this](const httplib::Request& request, httplib::Response& response) {
            const bool refused = beforeRouting(request, response) == Verdict::Handled;
            return refused ? response.status : 100;
        });
    server_.set_pre_routing_handler(
        [this](const httplib::Request& request, httplib::Response& response) {
            return beforeRouting(request, response);
        });
    server_.set_error_handler([this](const httplib::Request& request, httplib::Response& response) {
        explain(request, response);
    });
    server_.set_exception_handler(
        [this](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
            response.headers.erase("ETag");
            writeProblem(service_, response,
                         proto::makeProblem({ErrorCode::internal, "the server failed"}));
        });
    server_.onAnswer([](const httplib::Request&, httplib::Response& response) {
        response.user_data.erase("ticket");  // an unused place is free before the answer is seen
        releaseUpload(response);
    });
    server_.set_logger([this](const httplib::Request& request, const httplib::Response& response) {
        observe(request, response);
    });
}

void HttpServer::setRoutes() {
    for (const Route& route : routes()) {
        const auto handle = [this, &route](const httplib::Request& request,
                                           httplib::Response& response,
                                           const httplib::ContentReader* body) {
            Exchange exchange{request,
                              response,
                              body,
                              service_,
                              callerOf(response).name,
                              traceOf(response).traceparent()};
            route.handle(exchange);
        };
        const auto plain = [handle](const httplib::Request& request, httplib::Response& response) {
            handle(request, response, nullptr);
        };
        const std::string pattern = libraryPattern(route.path);
        if (route.upload)
            server_.Post(
                pattern,
                [handle](const httplib::Request& request, httplib::Response& response,
                         const httplib::ContentReader& body) { handle(request, response, &body); });
        else if (route.method == "DELETE")
            server_.Delete(pattern, plain);
        else
            server_.Get(pattern, plain);
    }
}

/// What every request has, however it is answered.
void HttpServer::begin(const httplib::Request& request, httplib::Response& response) const {
    requestId(request, response);
    traceOf(request, response);
    allowOrigin(service_.corsOrigins, request, response);
}

/// Everything that is decided before a body is read.
HttpServer::Verdict HttpServer::beforeRouting(const httplib::Request& request,
                                              httplib::Response& response) {
    begin(request, response);
    if (expectsTheUnknown(request)) {
        writeProblem(service_, response, {proto::transportProblemType(417)});
        return Verdict::Handled;
    }
    const bool reads = request.method == "GET" || request.method == "HEAD";
    const WebAsset* asset = findAsset(service_.assets, request.path);
    if (asset && reads) {
        writeAsset(request, response, *asset);
        return Verdict::Handled;
    }
    const Route* route = findRoute(request.method, request.path);
    const bool preflight = isPreflight(service_.corsOrigins, request);
    if (!preflight && refusesCaller(service_, request, response, route && route->upload))
        return Verdict::Handled;
    if (route)
        return route->upload && refusesUpload(request, response) ? Verdict::Handled
                                                                 : Verdict::Unhandled;

    const std::string allowed = asset ? "GET, HEAD, OPTIONS" : allowedMethods(request.path);
    if (allowed.empty()) {
        writeProblem(service_, response,
                     proto::makeProblem({ErrorCode::notFound, "there is no such path"}));
        return Verdict::Handled;
    }
    response.set_header("Allow", allowed);
    if (preflight)
        writePreflight(allowed, response);
    else if (request.method == "OPTIONS")
        response.status = 204;
    else
        writeProblem(
            service_, response,
            proto::makeProblem({ErrorCode::methodNotAllowed, "this path takes " + allowed}));
    return Verdict::Handled;
}

/// Checks what the headers say, then takes a place in the queue; it is kept with the response, so
/// that it is given back however the request ends. Called again after Expect: 100-continue.
bool HttpServer::refusesUpload(const httplib::Request& request, httplib::Response& response) {
    if (response.user_data.has("ticket")) return false;
    if (const auto checked = checkSubmission(request); !checked) {
        writeProblem(service_, response, checked.error());
        return true;
    }
    if (const auto admitted = admitUpload(request, response, service_); !admitted) {
        writeProblem(service_, response, admitted.error());
        return true;
    }
    auto ticket = service_.pool.admit();
    if (!ticket) {
        writeProblem(service_, response, proto::makeProblem(ticket.error()));
        return true;
    }
    response.user_data.set("ticket", std::make_shared<JobPool::Ticket>(*std::move(ticket)));
    return false;
}

/// Gives the errors that the library answers by itself their problem.
void HttpServer::explain(const httplib::Request& request, httplib::Response& response) const {
    requestId(request, response);
    if (bodyTimedOut(request) && response.status != 408) {
        response.status = 408;
        response.body.clear();
    }
    if (!response.body.empty() || response.status == kClientClosed) return;
    proto::Problem problem{proto::transportProblemType(response.status)};
    problem.type.status = response.status;
    for (const char* name : {"Content-Digest", "Repr-Digest", "Content-Disposition"})
        response.headers.erase(name);  // of the result that this problem stands in for
    if (response.status == 413) {
        problem.detail = "the body has more bytes than the server accepts";
        problem.limit = service_.limits.maxUploadBytes;
        problem.setting = "--max-upload";
    }
    writeProblem(service_, response, problem);
}

void HttpServer::observe(const httplib::Request& request, const httplib::Response& response) const {
    if (!settings_.observer) return;
    const auto elapsed = std::chrono::steady_clock::now() - request.start_time_;
    const Route* route = findRoute(request.method, request.path);
    settings_.observer(recordOf(request, response, route ? route->path : std::string_view("-"),
                                std::chrono::duration<double, std::milli>(elapsed).count()));
}

core::Result<void> HttpServer::start(Listener listener, const TlsContext* tls) {
    return front_.start(std::move(listener), tls);
}

void HttpServer::stop() {
    service_.stopping = true;
    front_.stop();
}

}  // namespace rivage::server
