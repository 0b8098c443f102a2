#pragma once

#include <string>

#include "core/base/result.h"

namespace rivage::server {

/// Where to listen.
struct Address {
    std::string host;  ///< without brackets; empty for a Unix socket
    int port = 0;      ///< 0: any free port
    std::string path;  ///< of a Unix socket

    [[nodiscard]] bool isUnix() const { return !path.empty(); }
    /// As users write it to reach the server: "http://127.0.0.1:8080", "unix:/run/rivage.sock".
    [[nodiscard]] std::string url() const;
};

/// Reads "host:port", "[::1]:port", ":port" or "unix:/path".
/// @errors invalidOption
core::Result<Address> parseAddress(const std::string& text);

/// Removes the socket file that a dead server left behind.
/// @errors busy if somebody listens there; invalidOption if the path is something else
core::Result<void> clearStaleSocket(const std::string& path);

/// Removes the file of a Unix socket; nothing for other addresses.
void removeSocketFile(const Address& address);

}  // namespace rivage::server
