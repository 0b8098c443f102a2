#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace rivage::client {

/// What is wrong with a command line that CLI11 refused: of a command that does not exist its name
/// and those that do, of an option that does not exist the one that was perhaps meant.
/// @param app        as it is after `parse`
/// @param arguments  without the name of the program
[[nodiscard]] std::string complaint(const CLI::App& app, const std::vector<std::string>& arguments,
                                    const CLI::ParseError& error);

}  // namespace rivage::client
