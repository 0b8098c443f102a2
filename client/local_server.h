#pragma once

#include <sys/types.h>

#include <string>

#include "client/endpoint.h"
#include "client/failure.h"
#include "client/interrupt.h"

namespace rivage::client {

/// A `rivage-server` of our own for one run: it listens on a Unix socket in a folder that only this
/// user can enter, and both are gone when this object is. The kernel ends the server if the client
/// dies first.
class LocalServer {
public:
    /// Starts `program` and waits until it answers. Settings of servers in the environment do not
    /// reach it.
    /// @param workers  conversions at a time, which share the processors
    /// @errors unreachable, with what the server said; cancelled
    static Outcome<LocalServer> start(const std::string& program, std::size_t workers,
                                      Interrupt& interrupt);

    LocalServer(LocalServer&& other) noexcept;
    LocalServer& operator=(LocalServer&&) = delete;
    ~LocalServer();

    [[nodiscard]] Endpoint endpoint() const { return {folder_ + "/socket", 0}; }

private:
    LocalServer() = default;
    [[nodiscard]] bool ended();
    [[nodiscard]] tl::unexpected<Failure> notStarted(const std::string& why) const;

    std::string folder_;
    pid_t child_ = -1;
};

/// The path of `rivage-server` beside the running program.
[[nodiscard]] std::string serverBeside();

}  // namespace rivage::client
