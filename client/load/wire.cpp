#include "client/load/wire.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

namespace rivage::client::load {
namespace {

IoResult fromErrno(Io ifBlocked) {
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return {ifBlocked};
    return {Io::failed, 0, errno};
}

bool isAddress(const std::string& host) {
    return host.find(':') != std::string::npos ||
           host.find_first_not_of("0123456789.") == std::string::npos;
}

}  // namespace

IoResult Wire::connect(const Target& target) {
    close();
    fd_ = socket(target.address.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd_ < 0) return {Io::failed, 0, errno};
    const int yes = 1;
    if (!target.endpoint.isUnix()) setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    if (target.tls) {
        tls_.reset(SSL_new(target.tls.get()));
        if (!tls_) return {Io::failed, 0, ENOMEM};
        SSL_set_fd(tls_.get(), fd_);
        SSL_set_connect_state(tls_.get());
        const std::string& host = target.endpoint.host;
        if (isAddress(host)) {
            X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(tls_.get()), host.c_str());
        } else {
            SSL_set_tlsext_host_name(tls_.get(), host.c_str());
            SSL_set1_host(tls_.get(), host.c_str());
        }
    }
    if (::connect(fd_, target.raw(), target.addressSize) == 0) return {Io::done};
    if (errno == EINPROGRESS) return {Io::wantWrite};
    return {Io::failed, 0, errno};
}

IoResult Wire::finishConnect() const {
    int error = 0;
    socklen_t size = sizeof error;
    getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) return {Io::failed, 0, error};
    sockaddr_storage peer{};
    size = sizeof peer;
    const bool there = getpeername(fd_, reinterpret_cast<sockaddr*>(&peer), &size) == 0;
    return {there ? Io::done : Io::wantWrite};
}

IoResult Wire::handshake() {
    if (!tls_) return {Io::done};
    ERR_clear_error();
    const int returned = SSL_do_handshake(tls_.get());
    return returned == 1 ? IoResult{Io::done} : tlsResult(returned);
}

IoResult Wire::send(std::span<iovec> pieces) {
    if (tls_) {
        ERR_clear_error();
        std::size_t sent = 0;
        const int returned =
            SSL_write_ex(tls_.get(), pieces.front().iov_base, pieces.front().iov_len, &sent);
        return returned == 1 ? IoResult{Io::done, sent} : tlsResult(returned);
    }
    msghdr message{};
    message.msg_iov = pieces.data();
    message.msg_iovlen = pieces.size();
    const ssize_t sent = sendmsg(fd_, &message, MSG_NOSIGNAL);
    return sent >= 0 ? IoResult{Io::done, static_cast<std::size_t>(sent)}
                     : fromErrno(Io::wantWrite);
}

IoResult Wire::receive(std::span<char> buffer) {
    if (tls_) {
        ERR_clear_error();
        std::size_t received = 0;
        const int returned = SSL_read_ex(tls_.get(), buffer.data(), buffer.size(), &received);
        return returned == 1 ? IoResult{Io::done, received} : tlsResult(returned);
    }
    const ssize_t received = recv(fd_, buffer.data(), buffer.size(), 0);
    if (received == 0) return {Io::closed};
    return received > 0 ? IoResult{Io::done, static_cast<std::size_t>(received)}
                        : fromErrno(Io::wantRead);
}

IoResult Wire::tlsResult(int returned) {
    const int system = errno;
    switch (SSL_get_error(tls_.get(), returned)) {
        case SSL_ERROR_WANT_READ: return {Io::wantRead};
        case SSL_ERROR_WANT_WRITE: return {Io::wantWrite};
        case SSL_ERROR_ZERO_RETURN: return {Io::closed};
        case SSL_ERROR_SYSCALL: return {system == 0 ? Io::closed : Io::failed, 0, system};
        default: return {Io::failed, 0, 0};
    }
}

void Wire::close() {
    tls_.reset();
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
}

}  // namespace rivage::client::load
