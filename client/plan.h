#pragma once

#include <string>
#include <vector>

#include "client/inputs.h"
#include "proto/json.h"

namespace rivage::client {

/// One conversion of a run: where the grid is and where its result goes; "-" is stdin or stdout.
struct PlannedFile {
    std::string input;
    std::string output;
};

/// Decides where each result goes, before anything is sent. Without `out` a result lands beside its
/// input with the extension of the format, and that of stdin on stdout. In a folder the results
/// stand as their inputs stand below the folders that were named.
/// @param out        a file, a folder (exists, ends in '/', or an input is a folder or a pattern),
///                   "-", or empty
/// @param extension  of the output format, without dot
/// @errors usage if several results would go to one place, or one onto an input
Outcome<std::vector<PlannedFile>> planFiles(const Inputs& inputs, const std::string& out,
                                            const std::string& extension);

/// Whether the result is newer than its input and, as far as it tells (a GLB does), was made with
/// these options, so that it need not be made again.
[[nodiscard]] bool isUpToDate(const PlannedFile& file, const proto::Json& options);

}  // namespace rivage::client
