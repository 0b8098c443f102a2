#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

namespace rivage::server {

/// What a serving process and its supervisor tell each other; in memory that both see.
struct Supervision {
    std::atomic<std::uint32_t> restarts{0};  ///< of the serving process, after crashes
    /// Set by the serving process once it serves: from then on its end is a crash, not a refusal
    /// to start.
    std::atomic<bool> started{false};
};

/// Runs `serve` in a process of its own, and again whenever that crashes: at once the first time,
/// with growing pauses of up to 5 s if it keeps crashing within a second. What this process has
/// opened before, such as listening sockets, each serving process inherits.
///
/// SIGTERM, SIGINT and SIGHUP go on to the serving process, which dies with this one.
/// Call it before any thread exists.
/// @param serve  gets the signals of `servingSignals` blocked; returns the exit code
/// @return       the exit code of the program: that of a serving process which ended by itself,
///               after a stop signal, or with 1 or 2 before anything was served
int supervise(const std::function<int(Supervision&)>& serve);

}  // namespace rivage::server
