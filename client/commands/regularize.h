#pragma once

#include "client/commands/session.h"
#include "client/plan.h"

namespace rivage::client {

/// What a run of `regularize` converts.
struct RegularizePlan {
    Inputs inputs;
    std::vector<PlannedFile> files;
};

/// Finds the inputs and decides where the results go; nothing is made or sent.
/// @errors usage
Outcome<RegularizePlan> planRegularize(const Invocation& invocation);

/// Makes the folders that the results go to.
/// @errors notWritten
Outcome<void> makeFolders(const Invocation& invocation, const RegularizePlan& plan);

/// Converts all files; the exit code is that of the first, in their order, that failed, else usage
/// if something that was met in the search for them could not be read.
ExitCode runRegularize(Session& session, const RegularizePlan& plan);

/// Converts all files, and again what changes, until a stop is asked for.
/// @return  ok after a stop, or cancelled if that ended a conversion; else why nothing can be
///          watched
ExitCode runWatch(Session& session, const RegularizePlan& plan);

}  // namespace rivage::client
