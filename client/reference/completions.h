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

/// A word that changes what may follow: the name of a command, or an option that takes a value.
struct Step {
    const TreeCommand* after = nullptr;    ///< the command that it stands behind
    std::vector<std::string> words;        ///< its names
    const TreeCommand* command = nullptr;  ///< the command that it is; null: an option
    bool many = false;                     ///< an option that takes several values
};

[[nodiscard]] std::vector<Step> stepsOf(const std::vector<const TreeCommand*>& commands);

/// The scripts; `completionScript` in reference.h says what they complete.
[[nodiscard]] std::string bashCompletion(const TreeCommand& root);
[[nodiscard]] std::string zshCompletion(const TreeCommand& root);
[[nodiscard]] std::string fishCompletion(const TreeCommand& root);

}  // namespace rivage::client
