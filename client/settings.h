#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "client/failure.h"

namespace rivage::client {

/// One line of the file of settings.
struct Setting {
    std::string name;   ///< of the option, with '-' or '_'
    std::string value;  ///< without the quotes around it
    std::string place;  ///< "FILE:LINE"
};

/// Reads settings: `name = value` a line, `#` begins a comment, quotes around a value are taken off.
/// @param file  its name, for the words of errors
/// @errors usage if a line is none, or a name comes twice
Outcome<std::vector<Setting>> readSettings(std::istream& stream, const std::string& file);

/// The settings of the file that --config or RIVAGE_CONFIG names, else of rivage/config in
/// $XDG_CONFIG_HOME or ~/.config, which need not be there.
/// @errors usage
Outcome<std::vector<Setting>> loadSettings(const std::vector<std::string>& arguments);

/// Makes settings the values that the options have if they are not given, in all commands.
/// @errors usage if there is no such option, or it cannot have the value
Outcome<void> applySettings(CLI::App& app, const std::vector<Setting>& settings);

/// @errors usage if a variable RIVAGE_CLIENT_... belongs to no option
Outcome<void> checkVariables(CLI::App& app);

}  // namespace rivage::client
