#pragma once

#include <string>

namespace rivage::client::load {

/// What stands below --help: examples and exit codes.
[[nodiscard]] std::string helpFooter();

}  // namespace rivage::client::load
