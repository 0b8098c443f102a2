#pragma once

#include <string>
#include <utility>
#include <vector>

#include "client/failure.h"

namespace rivage::client::load {

/// Writes files into a folder, which is made if need be; each appears only when it is whole.
/// @param files  names and contents
/// @errors notWritten
Outcome<void> writeFolder(const std::string& folder,
                          const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace rivage::client::load
