#pragma once

#include <string>
#include <string_view>

#include "client/failure.h"

namespace rivage::client {

/// Where a server listens.
struct Endpoint {
    std::string host;  ///< name or address; of a Unix socket its path
    int port = 0;      ///< 0: `host` is the path of a Unix socket
    [[nodiscard]] bool isUnix() const { return port == 0; }
    bool operator==(const Endpoint&) const = default;
};

/// Reads "http://HOST[:PORT]" or "unix:/PATH".
/// @errors usage
Outcome<Endpoint> parseEndpoint(std::string_view text);

/// The endpoint as `parseEndpoint` reads it.
[[nodiscard]] std::string toText(const Endpoint& endpoint);

}  // namespace rivage::client
