#pragma once

#include "client/command_line.h"

namespace rivage::client {

/// Commands that no server is needed for.
ExitCode runCompare(const Invocation& invocation, Console& console, const Interrupt& interrupt);
ExitCode runCompletions(const Invocation& invocation, Console& console);
ExitCode runMan(Console& console);

}  // namespace rivage::client
