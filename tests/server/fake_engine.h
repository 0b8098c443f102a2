#pragma once

#include <atomic>

#include "server/http/service.h"
#include "server/jobs/job_pool.h"

/// An engine that does what the grid says; the same grid gives the same bytes:
///   "ok..."         the artifact "asset of ok..."
///   "big:N"         an artifact of N bytes
///   "hold:MS..."    runs so many milliseconds, or until it is told to stop
///   "slow..."       runs until it is told to stop, or the gate opens
///   "stuck..."      as slow, but deaf to cancellation for 200 ms
///   "loop..."       never ends, deaf to everything
///   "crash...", "abort..."   the process dies by SIGSEGV, SIGABRT
///   "oom..."        takes memory until there is no more; only for a process with a limit
///   "empty", "big", "bad", "odd", "throw", "memory"   the failures of those kinds
namespace rivage::test {

/// What the fake engine shares with a test.
struct Gate {
    std::atomic<bool> open{false};
    std::atomic<int> running{0};
    std::atomic<int> started{0};
};

/// @param gate  must outlive the engine
[[nodiscard]] server::Engine fakeEngine(Gate& gate);

/// One sample, "dot".
[[nodiscard]] server::Samples fakeSamples();

}  // namespace rivage::test
