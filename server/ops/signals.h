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

/// Those, and the one that carries what the supervisor sends on: what a serving process blocks.
[[nodiscard]] sigset_t servingSignals();

/// Sends a signal on to the serving process, in a signal of its own: the signal itself could meet
/// an equal one there that came directly, and of two equal ones that wait the kernel keeps one.
void sendOn(pid_t serving, int signal);

/// Takes these signals one after the other, so that no handler runs in the middle of anything.
/// They must be blocked in every thread. A terminal, or systemd, sends a signal to the supervisor
/// and to the serving process, and the supervisor sends it on: both together are one request.
class SignalReader {
public:
    /// Waits for a request, or until the time is over.
    [[nodiscard]] SignalRequest next(std::chrono::milliseconds wait);

private:
    int sentOn_ = 0;
    int direct_ = 0;
    int stops_ = 0;  ///< requests to stop so far: the larger of the two
};

}  // namespace rivage::server
