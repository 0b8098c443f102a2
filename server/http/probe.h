#pragma once

#include <string>

#include "core/base/result.h"

namespace rivage::server {

/// Asks the admin port of a running server, as health checks of containers do without a shell.
///
/// @param adminListen  as for --admin-listen
/// @param question     "live", "ready" or "started"
/// @errors             invalidOption if there is no such port; timedOut if no answer comes within two
///                     seconds; internal with what the server says if the answer is no
core::Result<void> probe(const std::string& adminListen, const std::string& question);

}  // namespace rivage::server
