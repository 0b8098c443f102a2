#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "client/compare/compare.h"
#include "client/console.h"
#include "client/exit_code.h"
#include "client/interrupt.h"
#include "client/transport.h"
#include "proto/options.h"

namespace rivage::client {

enum class Command : std::uint8_t {
    regularize,
    inspect,
    sample,
    listSamples,
    options,
    health,
    jobsList,
    jobsStatus,
    jobsWait,
    jobsCancel,
    jobsFetch,
    compare,
    completions,
    man,
};

inline constexpr const char* kProgramSentence = "Rivage turns voxel art into smooth surfaces.";

/// A command line, read and checked.
struct Invocation {
    Command command = Command::health;
    std::vector<std::string> inputs;             ///< files, jobs, the name of a sample or a shell
    std::string out;                             ///< empty: not given
    std::vector<proto::OptionText> options;      ///< the conversion options that were given
    proto::JobOptions inForce;                   ///< the same, with what was not given
    std::string server;                          ///< empty: one of our own
    std::string apiKey;                          ///< empty: none
    std::string caFile;                          ///< empty: what the system trusts
    std::chrono::milliseconds timeout{600'000};  ///< for each input
    std::size_t workers = 0;  ///< conversions at a time; 0: as many as the server takes well
    bool ifNewer = false;
    bool stopOnError = false;
    bool watch = false;
    std::string jobState;  ///< empty: any
    std::size_t jobLimit = 20;
    CompareSettings compare = {};
    std::string color = "auto";
    bool quiet = false;
    bool json = false;
    RetryPolicy retry = {};
};

/// Either what to do, or the exit code if there is nothing (more) to do.
using CommandLine = tl::expected<Invocation, ExitCode>;

/// Reads the command line; help, the version and complaints go to the console.
/// @param arguments  without the name of the program
[[nodiscard]] CommandLine parseCommandLine(const std::vector<std::string>& arguments,
                                           Console& console);

/// Does what a command line asks for.
[[nodiscard]] ExitCode runCommand(const Invocation& invocation, Console& console,
                                  Interrupt& interrupt);

}  // namespace rivage::client
