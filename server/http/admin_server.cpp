#include "server/http/admin_server.h"

#include <sys/socket.h>

#include "server/http/exchange.h"
#include "server/http/metrics.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

constexpr std::size_t kThreads = 4;

}  // namespace

AdminServer::AdminServer(Service& service) {
    server_.new_task_queue = [] { return new httplib::ThreadPool(kThreads, kThreads, 64); };
    server_.set_read_timeout(2);
    server_.set_write_timeout(5);
    server_.set_keep_alive_timeout(1);
    server_.set_payload_max_length(1024);
    server_.set_tcp_nodelay(true);
    server_.set_socket_options([](socket_t socket) {
        const int on = 1;
        ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    });
    server_.Get("/livez", [](const httplib::Request&, httplib::Response& response) {
        writeJson(response, 200, {{"status", "alive"}});
    });
    server_.Get("/readyz", [&service](const httplib::Request&, httplib::Response& response) {
        if (!service.pool.draining()) return writeJson(response, 200, {{"status", "ready"}});
        writeProblem(service, response,
                     proto::makeProblem({ErrorCode::draining, "the server is stopping"}));
    });
    server_.Get("/metrics", [&service](const httplib::Request&, httplib::Response& response) {
        response.set_content(metricsText(service.pool), "text/plain; version=0.0.4");
    });
    server_.set_error_handler(
        [&service](const httplib::Request& request, httplib::Response& response) {
            requestId(request, response);
            if (!response.body.empty()) return;
            proto::Problem problem{proto::transportProblemType(response.status)};
            problem.type.status = response.status;
            writeProblem(service, response, problem);
        });
}

AdminServer::~AdminServer() { stop(); }

core::Result<Address> AdminServer::start(const Address& address) {
    if (address.isUnix()) return fail(ErrorCode::invalidOption, "the admin address is host:port");
    Address bound = address;
    const bool any = address.port == 0;
    if (any) bound.port = server_.bind_to_any_port(address.host);
    if (any ? bound.port <= 0 : !server_.bind_to_port(address.host, address.port))
        return fail(ErrorCode::busy, "cannot listen on " + address.url() + ": is it in use?");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    server_.wait_until_ready();
    return bound;
}

void AdminServer::stop() {
    if (!thread_.joinable()) return;
    server_.stop();
    thread_.join();
}

}  // namespace rivage::server
