#pragma once

#include <cstdint>

namespace rivage::client {

/// How a run of `rivage` ended, for scripts (README.md).
enum class ExitCode : std::uint8_t {
    ok = 0,
    usage = 2,        ///< the command line is wrong, or names an input that cannot be read
    refused = 3,      ///< the server refused the input or an option
    unreachable = 4,  ///< no server answered, or it could not be started
    busy = 5,         ///< the server stayed full, or the time was over
    failed = 6,       ///< the job or the server failed
    cancelled = 7,    ///< by Ctrl-C, SIGTERM, or somebody else at the server
    notWritten = 8,   ///< the result could not be written
};

}  // namespace rivage::client
