#pragma once

#include <httplib.h>

#include <thread>

#include "core/base/result.h"
#include "server/net/address.h"
#include "server/http/service.h"

namespace rivage::server {

/// GET /livez, /readyz and /metrics on a port and threads of their own, so that no load on the
/// public port can starve them.
class AdminServer {
public:
    /// @param service  must outlive the server
    explicit AdminServer(Service& service);
    ~AdminServer();

    /// @return the address that was bound @errors as `HttpServer::start`
    core::Result<Address> start(const Address& address);
    void stop();

private:
    httplib::Server server_;
    std::thread thread_;
};

}  // namespace rivage::server
