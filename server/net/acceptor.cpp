#include "server/net/acceptor.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <utility>

namespace rivage::server {
namespace {

/// Bytes that the kernel takes beyond those on their way.
constexpr int kUnsent = 256 << 10;

Fd openReserve() { return Fd(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

void nameOf(const sockaddr_storage& name, Accepted& accepted) {
    std::array<char, INET6_ADDRSTRLEN> text{};
    const void* host = nullptr;
    if (name.ss_family == AF_INET) {
        const auto& v4 = reinterpret_cast<const sockaddr_in&>(name);
        host = &v4.sin_addr;
        accepted.port = ntohs(v4.sin_port);
    } else if (name.ss_family == AF_INET6) {
        const auto& v6 = reinterpret_cast<const sockaddr_in6&>(name);
        host = &v6.sin6_addr;
        accepted.port = ntohs(v6.sin6_port);
    }
    if (host && ::inet_ntop(name.ss_family, host, text.data(), text.size()))
        accepted.host = text.data();
}

}  // namespace

Acceptor::Acceptor(Listener listener) : listener_(std::move(listener)), reserve_(openReserve()) {}

std::optional<Accepted> Acceptor::next() {
    while (true) {
        sockaddr_storage name{};
        socklen_t size = sizeof name;
        Accepted accepted{Fd(::accept4(fd(), reinterpret_cast<sockaddr*>(&name), &size,
                                       SOCK_CLOEXEC | SOCK_NONBLOCK)),
                          {},
                          0};
        exhausted_ = !accepted.fd && (errno == EMFILE || errno == ENFILE);
        if (accepted.fd) {
            const int on = 1;
            if (name.ss_family != AF_UNIX) {
                ::setsockopt(accepted.fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
                // What a slow reader leaves behind lies with us once, not in the kernel for each.
                ::setsockopt(accepted.fd.get(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsent,
                             sizeof kUnsent);
                ::setsockopt(accepted.fd.get(), SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
            }
            nameOf(name, accepted);
            return accepted;
        }
        if (exhausted_) {
            dropOne();
            return std::nullopt;
        }
        if (errno != EINTR && errno != ECONNABORTED) return std::nullopt;
    }
}

void Acceptor::dropOne() {
    reserve_.reset();
    Fd(::accept4(fd(), nullptr, nullptr, SOCK_CLOEXEC)).reset();
    reserve_ = openReserve();
}

}  // namespace rivage::server
