#pragma once

#include <string>
#include <vector>

#include "client/failure.h"

namespace rivage::client {

inline constexpr const char* kStandardStream = "-";

/// One conversion of a run: where the grid is and where its result goes; "-" is stdin or stdout.
struct PlannedFile {
    std::string input;
    std::string output;
};

/// Decides where each result goes, before anything is sent. Without `out` a result lands beside its
/// input with the extension of the format, and that of stdin on stdout.
/// @param out        a file, a folder (exists, or ends in '/'), "-", or empty
/// @param extension  of the output format, without dot
/// @errors usage if several results would go to one place, or one onto its own input
Outcome<std::vector<PlannedFile>> planFiles(const std::vector<std::string>& inputs,
                                            const std::string& out, const std::string& extension);

}  // namespace rivage::client
