#include <unistd.h>

#include <csignal>
#include <iostream>
#include <string>
#include <vector>

#include "client/load/command_line.h"

int main(int argc, char** argv) {
    using namespace rivage::client;
    std::signal(SIGPIPE, SIG_IGN);
    Console console{std::cin, std::cout, std::cerr, isatty(STDOUT_FILENO) == 1,
                    isatty(STDERR_FILENO) == 1};
    const auto options =
        load::parseLoadCommandLine(std::vector<std::string>(argv + 1, argv + argc), console);
    if (!options) return static_cast<int>(options.error());
    Interrupt interrupt;
    const SignalWatcher watcher(interrupt);
    return static_cast<int>(load::runLoadCommand(*options, console, interrupt));
}
