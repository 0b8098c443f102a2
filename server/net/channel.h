#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "server/net/fd.h"
#include "server/net/tls.h"

namespace rivage::server {

enum class IoStatus : std::uint8_t {
    done,
    wantRead,   ///< again when the socket has bytes
    wantWrite,  ///< again when the socket takes bytes
    ended,      ///< the peer sends nothing more
    failed,     ///< the connection is broken
};

struct Io {
    IoStatus status = IoStatus::done;
    std::size_t bytes = 0;
};

/// A connected socket that never blocks, bare or under TLS. One thread uses it at a time.
class Channel {
public:
    /// @param ssl  null for a bare socket
    Channel(Fd fd, SslPointer ssl) : fd_(std::move(fd)), ssl_(std::move(ssl)) {}

    [[nodiscard]] int fd() const { return fd_.get(); }
    [[nodiscard]] bool secure() const { return ssl_ != nullptr; }

    /// The server side of a TLS handshake; done at once on a bare socket.
    Io handshake();
    Io read(std::span<char> into);
    /// @return how many of the bytes the system has taken; at least one if done
    Io write(std::string_view bytes);
    /// Throws away what comes, as the socket has it.
    Io discard(std::span<char> scratch);
    /// Says that nothing more will be sent.
    void endWriting();
    /// Bytes that the system has taken and the peer has not confirmed.
    [[nodiscard]] std::uint64_t unconfirmed() const;

private:
    [[nodiscard]] Io sslResult(int result, std::size_t bytes) const;

    Fd fd_;
    SslPointer ssl_;
};

/// Waits until the socket can do what `status` wants, or the time is over, or it breaks.
/// @return false if the time was over
bool waitFor(const Channel& channel, IoStatus status, int milliseconds);

/// Whether the peer has ended or broken the connection, whatever is still unread.
[[nodiscard]] bool peerLeft(int socket);

/// Whether the connection is broken in both directions.
[[nodiscard]] bool isBroken(int socket);

}  // namespace rivage::server
