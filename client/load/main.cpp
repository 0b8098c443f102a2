#include <unistd.h>

#include <csignal>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "client/load/command_line.h"
#include "client/load/environment.h"

namespace {

int run(int argc, char** argv) {
    using namespace rivage::client;
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // `ulimit -f` is an error of writing, not of the program
    std::ios::sync_with_stdio(false);
    Console console{std::cin, std::cout, std::cerr, isatty(STDOUT_FILENO) == 1,
                    isatty(STDERR_FILENO) == 1};
    const auto options =
        load::parseLoadCommandLine(std::vector<std::string>(argv + 1, argv + argc), console);
    if (!options) return static_cast<int>(options.error());
    // Before anything is opened that would wait for ever if it could not be.
    if (const auto files = load::prepareFiles(); !files) {
        console.err << "rivage-load: " << describe(files.error()) << "\n" << std::flush;
        return static_cast<int>(load::LoadExit::late);
    }
    Interrupt interrupt;
    const SignalWatcher watcher(interrupt);
    return static_cast<int>(load::runLoadCommand(*options, console, interrupt));
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {  // such as memory that ran out
        std::cerr << "rivage-load: " << error.what() << "\n" << std::flush;
        return static_cast<int>(rivage::client::load::LoadExit::late);
    }
}
