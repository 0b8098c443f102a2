#pragma once

#include <CLI/App.hpp>
#include <map>
#include <string>

#include "client/command_line.h"

namespace rivage::client {

/// What CLI11 fills in while it reads a command line.
struct Parsed {
    Invocation invocation;
    std::map<std::string, std::string> options;  ///< of the conversion, by the name on the wire
    std::string apiKeyFile;
    std::string configFile;
    double seconds = 600;
    bool list = false;
};

/// Describes all of `rivage`: commands, options, their variables. An option that is configurable
/// may also stand in the file of settings, under its name.
/// @param parsed  has to live as long as `app` is used
void describeCommandLine(CLI::App& app, Parsed& parsed);

/// The option of a name on the wire: "draco_speed" is "--draco-speed".
[[nodiscard]] std::string flagName(std::string name);

/// The command that was read.
[[nodiscard]] Command commandOf(const CLI::App& app);

}  // namespace rivage::client
