#pragma once

#include <sys/uio.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "client/load/target.h"

namespace rivage::client::load {

/// How an operation on a socket that never waits has ended.
enum class Io : std::uint8_t { done, wantRead, wantWrite, closed, failed };

struct IoResult {
    Io io = Io::done;
    std::size_t bytes = 0;
    int error = 0;  ///< errno; 0 if TLS failed
};

/// A connection that never waits, with or without TLS.
class Wire {
public:
    Wire() = default;
    ~Wire() { close(); }
    Wire(const Wire&) = delete;
    Wire& operator=(const Wire&) = delete;

    /// Begins to connect. @return done, wantWrite while it goes on, failed
    IoResult connect(const Target& target);
    /// After the socket became writable. @return done, wantWrite if it still goes on, failed
    [[nodiscard]] IoResult finishConnect() const;
    /// Goes on with the TLS handshake; done at once without TLS.
    IoResult handshake();
    /// Sends the first pieces of what is left. @return done with the bytes that were taken
    IoResult send(std::span<iovec> pieces);
    IoResult receive(std::span<char> buffer);
    void close();

    [[nodiscard]] int fd() const { return fd_; }
    [[nodiscard]] bool secure() const { return tls_ != nullptr; }

private:
    IoResult tlsResult(int returned);
    int fd_ = -1;
    std::unique_ptr<SSL, decltype(&SSL_free)> tls_{nullptr, SSL_free};
};

}  // namespace rivage::client::load
