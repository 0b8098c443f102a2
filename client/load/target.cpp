#include "client/load/target.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/un.h>

#include <cstddef>
#include <cstring>
#include <utility>

namespace rivage::client::load {
namespace {

void fillUnix(Target& target, const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
    std::memcpy(&target.address, &address, sizeof address);
    target.addressSize = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size() + 1);
    target.host = "localhost";
    target.local = true;
}

bool isLoopback(const sockaddr* address) {
    if (address->sa_family == AF_INET) {
        const auto* v4 = reinterpret_cast<const sockaddr_in*>(address);
        return (ntohl(v4->sin_addr.s_addr) >> 24) == 127;
    }
    const auto* v6 = reinterpret_cast<const sockaddr_in6*>(address);
    if (IN6_IS_ADDR_V4MAPPED(&v6->sin6_addr)) return v6->sin6_addr.s6_addr[12] == 127;
    return IN6_IS_ADDR_LOOPBACK(&v6->sin6_addr);
}

Outcome<void> lookUp(Target& target) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const std::string port = std::to_string(target.endpoint.port);
    const int error = getaddrinfo(target.endpoint.host.c_str(), port.c_str(), &hints, &found);
    if (error != 0)
        return fail(ExitCode::unreachable, "The server has no address",
                    proto::inQuotes(target.endpoint.host) + ": " + gai_strerror(error));
    std::memcpy(&target.address, found->ai_addr, found->ai_addrlen);
    target.addressSize = found->ai_addrlen;
    target.local = isLoopback(found->ai_addr);
    freeaddrinfo(found);
    const bool v6 = target.endpoint.host.find(':') != std::string::npos;
    target.host = (v6 ? "[" + target.endpoint.host + "]" : target.endpoint.host) + ":" + port;
    return {};
}

/// Certificates are always checked; for one of a test server there is `caFile`.
Outcome<void> addTls(Target& target, const std::string& caFile) {
    target.tls.reset(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
    SSL_CTX* context = target.tls.get();
    if (context == nullptr) return fail(ExitCode::failed, "TLS does not work here");
    SSL_CTX_set_verify(context, SSL_VERIFY_PEER, nullptr);
    SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
    SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
    const int loaded = caFile.empty()
                           ? SSL_CTX_set_default_verify_paths(context)
                           : SSL_CTX_load_verify_locations(context, caFile.c_str(), nullptr);
    if (loaded == 1) return {};
    return fail(ExitCode::usage, "The certificates cannot be read", caFile);
}

}  // namespace

Outcome<Target> resolveTarget(const Endpoint& endpoint, const std::string& caFile) {
    Target target;
    target.endpoint = endpoint;
    if (endpoint.isUnix()) {
        fillUnix(target, endpoint.host);
    } else if (const auto found = lookUp(target); !found) {
        return tl::unexpected(found.error());
    }
    if (endpoint.tls)
        if (const auto added = addTls(target, caFile); !added) return tl::unexpected(added.error());
    return target;
}

}  // namespace rivage::client::load
