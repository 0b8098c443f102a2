#pragma once

#include <openssl/ssl.h>
#include <sys/socket.h>

#include <memory>
#include <string>

#include "client/endpoint.h"

namespace rivage::client::load {

/// Where the load goes: an endpoint whose name is resolved once, before the clock runs.
struct Target {
    Endpoint endpoint;
    sockaddr_storage address{};
    socklen_t addressSize = 0;
    std::string host;              ///< the value of the Host field
    bool local = false;            ///< this machine: loopback, or a Unix socket
    std::shared_ptr<SSL_CTX> tls;  ///< null: without TLS
    [[nodiscard]] const sockaddr* raw() const {
        return reinterpret_cast<const sockaddr*>(&address);
    }
};

/// @param caFile  certificates that are trusted instead of those of the system; empty: none
/// @errors unreachable if the name has no address; usage if the file cannot be read
Outcome<Target> resolveTarget(const Endpoint& endpoint, const std::string& caFile = {});

}  // namespace rivage::client::load
