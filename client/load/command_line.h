#pragma once

#include <CLI/App.hpp>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "client/console.h"
#include "client/load/selftest.h"

namespace rivage::client::load {

enum class LoadCommand : std::uint8_t { run, search, selftest, stub, man, completions };

/// A command line of `rivage-load`, as it was typed.
struct LoadOptions {
    LoadCommand command = LoadCommand::run;
    bool poisson = false;
    bool seedGiven = false;
    bool noKeepAlive = false;
    bool ownThis = false;
    bool json = false;
    bool quiet = false;
    int concurrency = 0;
    int threads = 1;
    int nice = -15;
    int port = 0;  ///< of stub
    int workMicroseconds = 0;
    std::string server;
    std::string admin;       ///< empty: /metrics is not asked for
    std::string apiKeyFile;  ///< empty: RIVAGE_API_KEY, or none
    std::string caFile;
    std::string mix;  ///< a file; empty: the sample "island"
    std::string get;  ///< instead of a mix: GET this path
    double rate = 0;
    std::string replay;
    double duration = 10;
    double warmup = 1;
    std::string slo;
    std::uint64_t seed = 1;
    std::string out;
    double verify = 0.05;
    std::vector<int> pins;
    std::size_t connections = 1000;
    double timeout = 30;
    std::uint64_t maxRequests = 10'000'000;
    double from = 0;  ///< of search
    double precision = 0.05;
    double window = 5;
    double maxErrors = 0.001;
    std::vector<double> curve{0.5, 1, 2, 3};
    SelftestPlan selftest;
    std::size_t bodySize = 2;  ///< of stub
    double stallAt = 0;
    double stallFor = 0;
    std::string shell;  ///< of completions
    std::string typed;  ///< the whole line
};

/// Adds every command and option to `app`; what is read goes to `options`, which must outlive it.
void describeLoadCommandLine(CLI::App& app, LoadOptions& options);

/// Reads a command line; help, the version and complaints go to the console.
/// @param arguments  without the name of the program
tl::expected<LoadOptions, LoadExit> parseLoadCommandLine(const std::vector<std::string>& arguments,
                                                         Console& console);

/// The man page (section 1).
[[nodiscard]] std::string loadManPage();
/// The completions for a shell. @param shell  one of those that the command line accepts
[[nodiscard]] std::string loadCompletions(const std::string& shell);

/// Does what a command line asks for.
LoadExit runLoadCommand(const LoadOptions& options, Console& console, Interrupt& interrupt);

}  // namespace rivage::client::load
