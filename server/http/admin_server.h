#pragma once

#include "core/base/result.h"
#include "server/http/service.h"
#include "server/net/front.h"

namespace rivage::server {

/// GET /livez, /readyz, /startupz and /metrics on a port, a front and threads of their own, so that
/// no load on the public port can starve them.
class AdminServer {
public:
    /// @param service  must outlive the server
    explicit AdminServer(Service& service);
    ~AdminServer();

    /// @errors as `HttpServer::start`
    core::Result<void> start(Listener listener);
    void stop();

private:
    HttpEngine server_;
    Front front_;
};

}  // namespace rivage::server
