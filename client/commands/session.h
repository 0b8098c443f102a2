#pragma once

#include <string>
#include <string_view>

#include "client/command_line.h"
#include "client/transport.h"

namespace rivage::client {

/// What every command that talks to a server works with.
struct Session {
    const Invocation& invocation;
    Console& console;
    Interrupt& interrupt;
    ServerAccess server;
    bool own = false;  ///< the server was started for this run, and ends with it

    /// A connection of its own for one thread, with the time that one input may take.
    [[nodiscard]] Transport connect() const;
};

/// Says a failure on `err`, and with --json its problem on `out`.
/// @param about  what it happened to; may be empty
ExitCode complain(const Invocation& invocation, Console& console, const std::string& about,
                  const Failure& failure);

/// The words for a failure, with its colour and the end of its line. Where a job is left at the
/// server, they say how its result is fetched.
/// @param output  where the result was to go; empty: not known
[[nodiscard]] std::string complaintText(const Session& session, const std::string& about,
                                        const Failure& failure, const std::string& output);

/// All bytes of an input; "-" is stdin. A stop ends the waiting for a pipe.
/// @errors usage; refused if it is larger than any server takes; cancelled
Outcome<std::string> readInput(const std::string& path, Console& console,
                               const Interrupt& interrupt);

inline constexpr std::size_t kSignatureBytes = 6;  ///< that tell the format of a grid

/// A refusal of a file that is not what its name says, in words of files: the server, which sees
/// no name, says only which formats there are.
/// @param start  the first `kSignatureBytes` of the file
[[nodiscard]] Failure inWordsOfFiles(const std::string& path, std::string_view start,
                                     Failure failure);

ExitCode runInspect(Session& session);
ExitCode runSample(Session& session);
ExitCode runListSamples(Session& session);
ExitCode runOptions(Session& session);
ExitCode runHealth(Session& session);
ExitCode runJobsList(Session& session);
ExitCode runJobsStatus(Session& session);
ExitCode runJobsWait(Session& session);
ExitCode runJobsCancel(Session& session);
ExitCode runJobsFetch(Session& session);

}  // namespace rivage::client
