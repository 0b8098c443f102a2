#pragma once

#include <httplib.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <thread>

#include "core/base/result.h"
#include "server/net/address.h"
#include "server/http/service.h"

namespace rivage::server {

/// One answered request, for the log.
struct RequestRecord {
    std::string id;
    std::string method;
    std::string route;  ///< of the table, or "-"
    int status = 0;
    double milliseconds = 0;
    std::size_t bytes = 0;  ///< of the answer's body
    std::string job;
};

struct HttpSettings {
    std::size_t connections = 128;  ///< served at a time, one thread each
    std::size_t backlog = 512;      ///< accepted and waiting; more are closed
    std::chrono::seconds writeTimeout{30};
    std::chrono::seconds idleTimeout{15};
    std::function<void(const RequestRecord&)> observer = {};
};

/// The public HTTP interface: routes, admission before bodies, a problem for every error.
class HttpServer {
public:
    /// @param service  must outlive the server
    HttpServer(HttpSettings settings, Service& service);
    ~HttpServer();

    /// Listens and serves from a thread of its own.
    /// @return the address that was bound, with its port
    /// @errors invalidOption or busy if the address cannot be bound
    core::Result<Address> start(const Address& address);
    /// Answers what is under way, within the write time-out, then takes nothing more and ends.
    void stop();

private:
    void setLimits();
    void setHooks();
    void setRoutes();
    using Verdict = httplib::Server::HandlerResponse;
    Verdict beforeRouting(const httplib::Request& request, httplib::Response& response);
    bool refusesUpload(const httplib::Request& request, httplib::Response& response);
    void explain(const httplib::Request& request, httplib::Response& response) const;
    void observe(const httplib::Request& request, const httplib::Response& response) const;

    const HttpSettings settings_;
    Service& service_;
    httplib::Server server_;
    std::thread thread_;
    std::string socketPath_;
};

}  // namespace rivage::server
