#pragma once

#include <string>
#include <string_view>

#include "client/failure.h"

namespace rivage::client {

/// Where a server listens.
struct Endpoint {
    std::string host;  ///< name or address; of a Unix socket its path
    int port = 0;      ///< 0: `host` is the path of a Unix socket
    bool tls = false;
    [[nodiscard]] bool isUnix() const { return port == 0; }
    bool operator==(const Endpoint&) const = default;
};

/// A server, and how this user reaches it and is known to it.
struct ServerAccess {
    Endpoint endpoint;
    std::string apiKey;  ///< empty: none is sent
    std::string caFile;  ///< PEM; empty: the certificates that the system trusts
};

/// Reads "http://HOST[:PORT]", "https://HOST[:PORT]" or "unix:/PATH"; an IPv6 address stands in
/// brackets.
/// @errors usage, also for "USER:PASSWORD@", which no words of the error show
Outcome<Endpoint> parseEndpoint(std::string_view text);

/// Whether what is sent there stays on this machine, as the address alone tells.
[[nodiscard]] bool isLoopback(const Endpoint& endpoint);

/// The endpoint as `parseEndpoint` reads it.
[[nodiscard]] std::string toText(const Endpoint& endpoint);

/// Reads an API key from a file: one line, as `Authorization` can carry it.
/// @errors usage if the file cannot be read or holds no key; the key itself is never shown
Outcome<std::string> readApiKey(const std::string& path);

/// The key of the file; without one that of RIVAGE_API_KEY; else none.
/// @param file  empty: not named
/// @errors usage if there is a file or a variable that holds no key
Outcome<std::string> apiKeyOf(const std::string& file);

/// Whether a text can be an API key: printable ASCII without spaces.
[[nodiscard]] bool isApiKey(std::string_view text);

}  // namespace rivage::client
