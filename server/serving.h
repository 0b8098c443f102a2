#pragma once

#include "server/http/service.h"
#include "server/jobs/crash_board.h"
#include "server/jobs/job_pool.h"
#include "server/net/listener.h"
#include "server/ops/settings.h"
#include "server/ops/supervisor.h"

namespace rivage::server {

/// What a serving process works with; all of it outlives the process.
struct Serving {
    const Settings& settings;
    const Engine& engine;
    const Samples& samples;
    const Listener& http;
    const Listener* admin = nullptr;  ///< null: there is no admin port
    CrashBoard& crashes;
    Supervision& supervision;
};

/// One serving process, from its stores to its drain: serves until SIGTERM or SIGINT, then lets
/// accepted jobs end, cancels what is left after the time-out, and closes its sockets. A second
/// stop signal ends the process at once, with code 130.
/// @return the exit code: 0, or 1 if it cannot start
int serveUntilStopped(const Serving& serving);

}  // namespace rivage::server
