#pragma once

#include <string>
#include <vector>

#include "client/reference/reference.h"

namespace rivage::client {

/// Whether a program can be run.
[[nodiscard]] bool isInstalled(const std::string& program);

/// What a command prints on both streams; `status` is how it ended.
[[nodiscard]] std::string outputOf(const std::string& command, int& status);

/// Asks the real shell what it would offer, sorted.
/// @param script  the completion script of `program`
/// @param line    what has been typed, the cursor behind it: "sample-tool jobs f"
/// @param folder  where the shell stands, so that files can be completed
[[nodiscard]] std::vector<std::string> offers(Shell shell, const std::string& script,
                                              const std::string& line, const std::string& folder);

}  // namespace rivage::client
