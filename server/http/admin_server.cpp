#include "server/http/admin_server.h"

#include <chrono>
#include <utility>

#include "server/http/exchange.h"
#include "server/http/metrics.h"

namespace rivage::server {
namespace {

using core::ErrorCode;

/// Few and impatient: its clients are probes.
NetLimits adminLimits() {
    NetLimits limits;
    limits.connections = 64;
    limits.handlers = 2;
    limits.headTimeout = std::chrono::seconds(2);
    limits.stopTimeout = std::chrono::seconds(5);
    return limits;
}

}  // namespace

AdminServer::AdminServer(Service& service) : front_(adminLimits(), server_) {
    server_.set_payload_max_length(1024);
    server_.Get("/livez", [](const httplib::Request&, httplib::Response& response) {
        writeJson(response, 200, {{"status", "alive"}});
    });
    server_.Get("/readyz", [&service](const httplib::Request&, httplib::Response& response) {
        if (!service.unready && !service.pool.draining())
            return writeJson(response, 200, {{"status", "ready"}});
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

core::Result<void> AdminServer::start(Listener listener) {
    return front_.start(std::move(listener));
}

void AdminServer::stop() { front_.stop(); }

}  // namespace rivage::server
