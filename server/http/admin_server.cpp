#include "server/http/admin_server.h"

#include <chrono>
#include <utility>

#include "server/http/exchange.h"

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

/// So long the loop may show no life before it counts as stuck.
constexpr std::chrono::seconds kLongestSilence{15};

/// What has shown no life for too long, or null.
const char* whatIsStuck(const Service& service) {
    if (service.loopBeat && Clock::now() - service.loopBeat() > kLongestSilence)
        return "the connection loop is stuck";
    if (service.pool.stuck()) return "a worker is stuck";
    return nullptr;
}

void writeUnready(const Service& service, httplib::Response& response, const char* reason) {
    proto::Problem problem{proto::problemType(ErrorCode::internal), reason};
    problem.type.status = 503;
    writeProblem(service, response, problem);
}

}  // namespace

AdminServer::AdminServer(Service& service) : front_(adminLimits(), server_) {
    server_.set_payload_max_length(1024);
    server_.Get("/livez", [&service](const httplib::Request&, httplib::Response& response) {
        if (const char* stuck = whatIsStuck(service)) return writeUnready(service, response, stuck);
        writeJson(response, 200, {{"status", "alive"}});
    });
    server_.Get("/startupz", [](const httplib::Request&, httplib::Response& response) {
        writeJson(response, 200, {{"status", "started"}});
    });
    server_.Get("/readyz", [&service](const httplib::Request&, httplib::Response& response) {
        if (!service.unready && !service.pool.draining())
            return writeJson(response, 200, {{"status", "ready"}});
        writeProblem(service, response,
                     proto::makeProblem({ErrorCode::draining, "the server is stopping"}));
    });
    server_.Get("/metrics", [&service](const httplib::Request&, httplib::Response& response) {
        response.set_content(service.metrics ? service.metrics() : std::string(),
                             "text/plain; version=0.0.4; charset=utf-8");
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
