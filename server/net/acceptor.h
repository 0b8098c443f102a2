#pragma once

#include <optional>
#include <string>

#include "server/net/listener.h"

namespace rivage::server {

/// A connection that was just accepted.
struct Accepted {
    Fd fd;
    std::string host;  ///< of the peer; empty on a Unix socket
    int port = 0;
};

/// Takes connections from a listener, also when the process is out of descriptors.
class Acceptor {
public:
    explicit Acceptor(Listener listener);

    [[nodiscard]] int fd() const { return listener_.fd.get(); }
    [[nodiscard]] const Address& address() const { return listener_.address; }

    /// The next connection, or nothing if none waits. Without a descriptor for it, the connection
    /// is closed, because it would otherwise keep the listener readable for ever.
    std::optional<Accepted> next();
    /// Whether the last call found no descriptor left: better wait a while.
    [[nodiscard]] bool exhausted() const { return exhausted_; }

private:
    void dropOne();

    Listener listener_;
    Fd reserve_;  ///< given up for a moment to accept and close what cannot be served
    bool exhausted_ = false;
};

}  // namespace rivage::server
