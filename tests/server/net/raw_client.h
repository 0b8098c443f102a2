#pragma once

#include <chrono>
#include <string>

#include "server/net/address.h"
#include "server/net/fd.h"

namespace rivage::test {

/// One connection whose bytes a test sends and reads by itself.
class RawClient {
public:
    /// @param receiveBuffer  bytes that the kernel takes in for us; 0: its default
    explicit RawClient(const server::Address& address, int receiveBuffer = 0);

    [[nodiscard]] bool connected() const { return connected_; }
    [[nodiscard]] int fd() const { return fd_.get(); }
    /// @return false if the connection is broken
    bool send(const std::string& bytes) const;
    void endSending() const;
    void close() { fd_.reset(); }

    /// The bytes until `end` is among them, the peer closes, or the time is over.
    std::string readUntil(const std::string& end,
                          std::chrono::milliseconds time = std::chrono::seconds(5));
    /// One answer with its body by Content-Length; what follows stays for the next call.
    std::string readAnswer(std::chrono::milliseconds time = std::chrono::seconds(5));
    /// Everything until the peer closes, or the time is over.
    std::string readAll(std::chrono::milliseconds time = std::chrono::seconds(5));
    /// Whether the peer has closed, with nothing left to read. Waits that long for it.
    bool closedWithin(std::chrono::milliseconds time);

private:
    bool receive(std::chrono::steady_clock::time_point until);

    server::Fd fd_;
    bool connected_ = false;
    bool ended_ = false;
    std::string received_;
};

/// A request without a body.
[[nodiscard]] std::string get(const std::string& path, const std::string& headers = {});

/// The status of an answer, or 0.
[[nodiscard]] int statusOf(const std::string& answer);

}  // namespace rivage::test
