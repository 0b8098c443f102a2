#include "server/net/channel.h"

#include <linux/sockios.h>
#include <openssl/err.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cerrno>

namespace rivage::server {
namespace {

Io socketResult(ssize_t result, IoStatus again) {
    if (result > 0) return {IoStatus::done, static_cast<std::size_t>(result)};
    if (result == 0) return {IoStatus::ended, 0};
    const bool later = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    return {later ? again : IoStatus::failed, 0};
}

short pollNow(int socket, short events) {
    pollfd watched{socket, events, 0};
    return ::poll(&watched, 1, 0) > 0 ? watched.revents : short{0};
}

}  // namespace

Io Channel::sslResult(int result, std::size_t bytes) const {
    if (result == 1) return {IoStatus::done, bytes};
    switch (::SSL_get_error(ssl_.get(), result)) {
        case SSL_ERROR_WANT_READ: return {IoStatus::wantRead, 0};
        case SSL_ERROR_WANT_WRITE: return {IoStatus::wantWrite, 0};
        case SSL_ERROR_ZERO_RETURN: return {IoStatus::ended, 0};
        default: return {IoStatus::failed, 0};
    }
}

Io Channel::handshake() {
    if (!ssl_) return {};
    ::ERR_clear_error();
    return sslResult(::SSL_do_handshake(ssl_.get()), 0);
}

Io Channel::read(std::span<char> into) {
    if (!ssl_)
        return socketResult(::recv(fd(), into.data(), into.size(), MSG_DONTWAIT),
                            IoStatus::wantRead);
    ::ERR_clear_error();
    std::size_t bytes = 0;
    const int result = ::SSL_read_ex(ssl_.get(), into.data(), into.size(), &bytes);
    return sslResult(result, bytes);
}

Io Channel::write(std::string_view bytes) {
    if (!ssl_)
        return socketResult(::send(fd(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL),
                            IoStatus::wantWrite);
    ::ERR_clear_error();
    std::size_t written = 0;
    const int result = ::SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &written);
    return sslResult(result, written);
}

Io Channel::discard(std::span<char> scratch) {
    return socketResult(::recv(fd(), scratch.data(), scratch.size(), MSG_DONTWAIT),
                        IoStatus::wantRead);
}

void Channel::endWriting() {
    if (ssl_ && ::SSL_is_init_finished(ssl_.get())) {
        ::ERR_clear_error();
        ::SSL_shutdown(ssl_.get());
    }
    ::shutdown(fd(), SHUT_WR);
}

std::uint64_t Channel::unconfirmed() const {
    int bytes = 0;
    return ::ioctl(fd(), SIOCOUTQ, &bytes) == 0 && bytes > 0 ? static_cast<std::uint64_t>(bytes)
                                                             : 0;
}

bool waitFor(const Channel& channel, IoStatus status, int milliseconds) {
    const short events = status == IoStatus::wantWrite ? POLLOUT : POLLIN;
    pollfd watched{channel.fd(), events, 0};
    return ::poll(&watched, 1, milliseconds) != 0;
}

bool peerLeft(int socket) {
    return (pollNow(socket, POLLRDHUP) & (POLLRDHUP | POLLHUP | POLLERR | POLLNVAL)) != 0;
}

bool isBroken(int socket) { return (pollNow(socket, 0) & (POLLHUP | POLLERR | POLLNVAL)) != 0; }

}  // namespace rivage::server
