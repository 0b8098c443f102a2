#pragma once

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <cstdint>

namespace rivage::server {

/// What the signals of a server ask for.
enum class SignalRequest : std::uint8_t {
    none,
    reload,    ///< SIGHUP
    stop,      ///< SIGTERM: drain
    stopSoon,  ///< SIGINT, from a terminal: drain without the delay for load balancers
    end,       ///< a second stop signal: end at once
};

/// SIGTERM, SIGINT and SIGHUP, as a set.
[[nodiscard]] sigset_t handledSignals();

/// Takes these signals one after the other, so that no handler runs in the middle of anything.
/// They must be blocked in every thread. A terminal, or systemd, sends a signal to the supervisor
/// and to the serving process, and the supervisor sends it on: both together are one request.
class SignalReader {
public:
    /// @param supervisor  whose signals may be copies of what others have sent; 0: there is none
    explicit SignalReader(pid_t supervisor) : supervisor_(supervisor) {}
    /// Waits for a request, or until the time is over.
    [[nodiscard]] SignalRequest next(std::chrono::milliseconds wait);

private:
    const pid_t supervisor_;
    int fromSupervisor_ = 0;
    int fromOthers_ = 0;
    int stops_ = 0;  ///< requests to stop so far: the larger of the two
};

}  // namespace rivage::server
