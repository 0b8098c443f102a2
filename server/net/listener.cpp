#include "server/net/listener.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <memory>

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// Connections that the kernel holds while nobody accepts, as during a restart; the kernel cuts it
/// to net.core.somaxconn.
constexpr int kBacklog = 4096;

tl::unexpected<core::Error> cannotListen(const Address& address) {
    const int error = errno;
    const bool taken = error == EADDRINUSE;
    return fail(taken ? ErrorCode::busy : ErrorCode::invalidOption,
                "cannot listen on " + address.url() + ": " +
                    (taken ? "it is in use" : std::strerror(error)));
}

core::Result<Listener> listenOnPath(const Address& address) {
    if (auto cleared = clearStaleSocket(address.path); !cleared) return fail(cleared.error());
    Listener listener{Fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)),
                      address};
    sockaddr_un name{};
    name.sun_family = AF_UNIX;
    std::memcpy(name.sun_path, address.path.data(), address.path.size());
    if (::bind(listener.fd.get(), reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0 ||
        ::chmod(address.path.c_str(), 0660) != 0 || ::listen(listener.fd.get(), kBacklog) != 0)
        return cannotListen(address);
    return listener;
}

int portOf(int socket) {
    sockaddr_storage name{};
    socklen_t size = sizeof name;
    ::getsockname(socket, reinterpret_cast<sockaddr*>(&name), &size);
    return ntohs(name.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(&name)->sin6_port
                                            : reinterpret_cast<sockaddr_in*>(&name)->sin_port);
}

/// A listening socket at this name, or an empty one with the reason in errno.
Fd listenAt(const addrinfo& name) {
    Fd fd(::socket(name.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (!fd) return fd;
    // Not SO_REUSEPORT, which lets two servers share a port by accident.
    const int on = 1;
    ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    const int off = 0;
    if (name.ai_family == AF_INET6)
        ::setsockopt(fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
    if (::bind(fd.get(), name.ai_addr, name.ai_addrlen) == 0 && ::listen(fd.get(), kBacklog) == 0)
        return fd;
    const int error = errno;
    fd.reset();
    errno = error;
    return fd;
}

}  // namespace

core::Result<Listener> listenOn(const Address& address) {
    if (address.isUnix()) return listenOnPath(address);
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    addrinfo* found = nullptr;
    if (const int error = ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(),
                                        &hints, &found))
        return fail(ErrorCode::invalidOption,
                    "cannot listen on " + address.url() + ": " + ::gai_strerror(error));
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> names(found, &::freeaddrinfo);
    for (const addrinfo* name = names.get(); name; name = name->ai_next)
        if (Fd fd = listenAt(*name)) {
            Listener listener{std::move(fd), address};
            listener.address.port = portOf(listener.fd.get());
            return listener;
        }
    return cannotListen(address);
}

core::Result<Listener> share(const Listener& listener) {
    Fd fd(::fcntl(listener.fd.get(), F_DUPFD_CLOEXEC, 0));
    if (!fd) return fail(ErrorCode::internal, "no file descriptor is left");
    return Listener{std::move(fd), listener.address};
}

}  // namespace rivage::server
