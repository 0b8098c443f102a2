#pragma once

#include <cstdint>
#include <vector>

#include "client/commands/session.h"
#include "client/plan.h"

namespace rivage::client {

/// How one file of a batch ended.
struct FileOutcome {
    ExitCode exit = ExitCode::ok;
    bool done = false;        ///< tried, or skipped; false: the batch was over before
    bool skipped = false;     ///< the result is up to date
    bool noServer = false;    ///< nobody took the job
    std::uint64_t bytes = 0;  ///< of the result
};

/// Converts files, `workers` at a time, and tells of each on one line when it ends: in words on
/// `err`, with --json as its report or problem on `out`. A failure does not keep the others from
/// being converted, but a stop does, and so does a server that is not there.
/// @return  in the order of the files
std::vector<FileOutcome> convertFiles(Session& session, const std::vector<PlannedFile>& files);

/// Says how many were converted, failed and are up to date, if there were several or one was passed
/// over.
void summarize(Session& session, const std::vector<FileOutcome>& outcomes, double seconds);

/// The exit code of the first file that failed.
[[nodiscard]] ExitCode firstFailure(const std::vector<FileOutcome>& outcomes);

}  // namespace rivage::client
