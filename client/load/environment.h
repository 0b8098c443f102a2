#pragma once

#include <string>

#include "client/interrupt.h"
#include "client/load/target.h"
#include "proto/json.h"

namespace rivage::client::load {

/// What a figure means little without: processor, cores, governor, kernel, memory, load of the
/// machine, versions of both sides, priority, command.
/// @param command  as it was typed; keys never stand there
[[nodiscard]] proto::Json describeEnvironment(const std::string& command);

/// What GET /version of the server says; null if it has no such page.
/// @errors unreachable
Outcome<proto::Json> serverVersion(const ServerAccess& server, Interrupt& interrupt);

/// Takes a priority above that of the server, so that what measures does not wait for what it
/// measures, as far as the user may.
/// @param nice  -20..19
void prepareProcess(int nice);

/// A run of one thread and a few connections needs so many files.
inline constexpr int kFewestFiles = 16;

/// Lets as many files be open as the user may have.
/// @errors failed if not even `kFewestFiles` more can be opened
Outcome<void> prepareFiles();

}  // namespace rivage::client::load
