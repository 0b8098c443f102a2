#include "server/http/http_server.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <memory>
#include <utility>

#include "server/http/exchange.h"
#include "server/http/routes.h"
#include "server/http/upload.h"

namespace rivage::server {
namespace {

using namespace std::chrono_literals;
using core::ErrorCode;
using core::fail;

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

/// Counts a request as unanswered for as long as its response exists, so that `stop` can wait: the
/// library itself cuts streamed answers off when it stops.
void countUntilWritten(Service& service, httplib::Response& response) {
    ++service.unanswered;
    response.user_data.set("unanswered", std::shared_ptr<Service>(&service, [](Service* counted) {
                               --counted->unanswered;
                           }));
}

const WebAsset* findAsset(std::span<const WebAsset> assets, const std::string& path) {
    for (const WebAsset& asset : assets)
        if (asset.path == path) return &asset;
    return nullptr;
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
    : settings_(std::move(settings)), service_(service) {
    setLimits();
    setHooks();
    setRoutes();
}

HttpServer::~HttpServer() { stop(); }

void HttpServer::setLimits() {
    server_.new_task_queue = [this] {
        return new httplib::ThreadPool(settings_.connections, settings_.connections,
                                       settings_.backlog);
    };
    server_.set_read_timeout(service_.readTimeout.count());
    server_.set_write_timeout(settings_.writeTimeout.count());
    server_.set_keep_alive_timeout(settings_.idleTimeout.count());
    server_.set_keep_alive_max_count(1000);
    server_.set_payload_max_length(service_.limits.maxUploadBytes + kBodyOverhead);
    server_.set_tcp_nodelay(true);
    // Not the library's default of SO_REUSEPORT, which lets two servers share a port by accident.
    server_.set_socket_options([](socket_t socket) {
        const int on = 1;
        ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    });
    server_.set_default_headers({{"X-Content-Type-Options", "nosniff"}});
}

void HttpServer::setHooks() {
    server_.set_expect_100_continue_handler(
        [this](const httplib::Request& request, httplib::Response& response) {
            const Route* route = findRoute(request.method, request.path);
            requestId(request, response);
            if (route && route->upload && refusesUpload(request, response)) return response.status;
            return 100;
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
    server_.set_post_routing_handler([](const httplib::Request&, httplib::Response& response) {
        response.user_data.erase("ticket");  // an unused place is free before the answer is seen
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
            Exchange exchange{request, response, body, service_};
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

/// Everything that is decided before a body is read.
HttpServer::Verdict HttpServer::beforeRouting(const httplib::Request& request,
                                              httplib::Response& response) {
    countUntilWritten(service_, response);
    requestId(request, response);
    const bool reads = request.method == "GET" || request.method == "HEAD";
    const WebAsset* asset = findAsset(service_.assets, request.path);
    if (asset && reads) {
        writeAsset(request, response, *asset);
        return Verdict::Handled;
    }
    if (const Route* route = findRoute(request.method, request.path))
        return route->upload && refusesUpload(request, response) ? Verdict::Handled
                                                                 : Verdict::Unhandled;

    const std::string allowed = asset ? "GET, HEAD, OPTIONS" : allowedMethods(request.path);
    if (allowed.empty()) {
        writeProblem(service_, response,
                     proto::makeProblem({ErrorCode::notFound, "there is no such path"}));
        return Verdict::Handled;
    }
    response.set_header("Allow", allowed);
    if (request.method == "OPTIONS")
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
    if (const auto checked = checkUploadHeaders(request, service_); !checked) {
        writeProblem(service_, response, checked.error());
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
    if (!response.body.empty() || response.status == kClientClosed) return;
    const bool crowded =
        response.status == 400 && request.headers.size() >= CPPHTTPLIB_HEADER_MAX_COUNT;
    if (crowded) response.status = 431;
    proto::Problem problem{proto::transportProblemType(response.status)};
    problem.type.status = response.status;
    if (response.status == 413) {
        problem.detail = "the body has more bytes than the server accepts";
        problem.limit = service_.limits.maxUploadBytes;
        problem.setting = "--max-upload";
    }
    if (response.status == 431) problem.limit = CPPHTTPLIB_HEADER_MAX_COUNT;
    if (response.status == 414) problem.limit = CPPHTTPLIB_REQUEST_URI_MAX_LENGTH;
    writeProblem(service_, response, problem);
}

void HttpServer::observe(const httplib::Request& request, const httplib::Response& response) const {
    if (!settings_.observer) return;
    const auto elapsed = std::chrono::steady_clock::now() - request.start_time_;
    settings_.observer({response.get_header_value("X-Request-ID"), request.method,
                        request.matched_route.empty() ? "-" : request.matched_route,
                        response.status, std::chrono::duration<double, std::milli>(elapsed).count(),
                        response.body.empty() ? response.content_length_ : response.body.size(),
                        response.get_header_value("Rivage-Job")});
}

core::Result<Address> HttpServer::start(const Address& address) {
    Address bound = address;
    if (address.isUnix()) {
        if (auto cleared = clearStaleSocket(address.path); !cleared) return fail(cleared.error());
        server_.set_address_family(AF_UNIX);
        if (!server_.bind_to_port(address.path, 1))
            return fail(ErrorCode::invalidOption, "cannot listen at " + address.path);
        ::chmod(address.path.c_str(), 0660);
        socketPath_ = address.path;
    } else if (address.port == 0) {
        bound.port = server_.bind_to_any_port(address.host);
        if (bound.port <= 0)
            return fail(ErrorCode::invalidOption, "cannot listen on " + address.host);
    } else if (!server_.bind_to_port(address.host, address.port)) {
        return fail(ErrorCode::busy, "cannot listen on " + address.url() + ": is it in use?");
    }
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    server_.wait_until_ready();
    return bound;
}

void HttpServer::stop() {
    if (!thread_.joinable()) return;
    service_.stopping = true;
    const auto until = Clock::now() + settings_.writeTimeout;
    while (service_.unanswered > 0 && Clock::now() < until) std::this_thread::sleep_for(5ms);
    server_.stop();
    thread_.join();
    if (!socketPath_.empty()) ::unlink(socketPath_.c_str());
}

}  // namespace rivage::server
