#pragma once

#include <httplib.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/http/request_record.h"
#include "server/http/service.h"
#include "server/net/front.h"

namespace rivage::server {

struct HttpSettings {
    NetLimits net = {};
    std::vector<std::string> trustedProxies = {};  ///< addresses whose X-Forwarded-For is believed
    std::function<void(const RequestRecord&)> observer = {};
};

/// The public HTTP interface: routes, admission before bodies, a problem for every error.
class HttpServer {
public:
    /// @param service  must outlive the server
    HttpServer(HttpSettings settings, Service& service);
    ~HttpServer();

    /// Serves from threads of its own.
    /// @param tls  null for plain HTTP; else it must outlive the server
    /// @errors internal if the system has no descriptors left
    core::Result<void> start(Listener listener, const TlsContext* tls = nullptr);
    /// Answers what is under way, within the time-out, takes nothing more and ends. What comes
    /// later waits in the kernel for another process that shares the listener.
    void stop();

    /// Its connections, for health and metrics.
    [[nodiscard]] const Front& front() const { return front_; }

private:
    void setLimits();
    void setHooks();
    void setRoutes();
    using Verdict = httplib::Server::HandlerResponse;
    void begin(const httplib::Request& request, httplib::Response& response) const;
    Verdict beforeRouting(const httplib::Request& request, httplib::Response& response);
    bool refusesUpload(const httplib::Request& request, httplib::Response& response);
    void explain(const httplib::Request& request, httplib::Response& response) const;
    void observe(const httplib::Request& request, const httplib::Response& response) const;

    const HttpSettings settings_;
    Service& service_;
    HttpEngine server_;
    Front front_;
};

}  // namespace rivage::server
