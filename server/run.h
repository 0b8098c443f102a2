#pragma once

#include "server/http/service.h"
#include "server/jobs/job_pool.h"

namespace rivage::server {

/// The whole server program: reads the command line, binds the sockets, serves until a stop signal
/// and drains; supervised, also through crashes.
/// Call it first in `main`, before any thread exists.
/// @return the exit code: 0 after a stop signal, 1 if it cannot start, 2 for a wrong command line,
///         130 after a second stop signal
int runServer(int argc, const char* const* argv, const Engine& engine, const Samples& samples);

}  // namespace rivage::server
