#pragma once

#include <string>
#include <vector>

#include "client/reference/command_tree.h"

namespace rivage::client {

/// What may stand after a command besides options: the commands below it, or its positionals.
struct Arguments {
    std::vector<std::string> words;
    bool files = false;
    bool folders = false;
};

[[nodiscard]] Arguments argumentsOf(const TreeCommand& command);

/// The scripts; `completionScript` in reference.h says what they complete.
[[nodiscard]] std::string bashCompletion(const TreeCommand& root);
[[nodiscard]] std::string zshCompletion(const TreeCommand& root);
[[nodiscard]] std::string fishCompletion(const TreeCommand& root);

}  // namespace rivage::client
