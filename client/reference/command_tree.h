#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "client/reference/joined.h"

namespace rivage::client {

/// What may stand where an option wants its value.
struct ValueKind {
    std::string name;                ///< as --help shows it: "PATH", "draco|none"
    std::vector<std::string> words;  ///< those that may be typed as they are
    bool files = false;
    bool folders = false;  ///< folders alone
    std::string range;     ///< "0.001 - 1e+06"; empty if there is none
};

/// One option, flag or positional.
struct TreeOption {
    std::vector<std::string> names;  ///< "-o", "--out": short before long; none for a positional
    std::string positional;          ///< "IN"
    std::string description;
    std::string group;
    std::string defaultText;
    std::string environment;
    ValueKind value;
    bool takesValue = false;
    bool many = false;  ///< takes every word up to the next option
    bool required = false;
};

/// One command with the commands below it; hidden options and commands are left out.
struct TreeCommand {
    std::vector<std::string> path;  ///< "rivage", "jobs", "fetch"
    std::vector<std::string> aliases;
    std::string description;
    std::vector<TreeOption> options;      ///< its own
    std::vector<TreeOption> inherited;    ///< of the commands above that it hands options to
    std::vector<TreeOption> positionals;  ///< in order
    std::vector<TreeCommand> commands;
};

/// Reads a CLI11 tree into what the writers of this folder need.
[[nodiscard]] TreeCommand readTree(const CLI::App& app);

/// The options that may be typed after a command: its own and those it hands up.
[[nodiscard]] std::vector<TreeOption> allOptions(const TreeCommand& command);

/// The command and all below it, depth first.
[[nodiscard]] std::vector<const TreeCommand*> flatten(const TreeCommand& command);

/// "rivage jobs fetch"
[[nodiscard]] std::string pathText(const TreeCommand& command, const char* between = " ");

/// A name for a function of a shell script: whatever a shell would not take is an underscore.
[[nodiscard]] std::string identifier(std::string text);

/// The text in single quotes for bash and zsh.
[[nodiscard]] std::string shellQuoted(const std::string& text);

}  // namespace rivage::client
