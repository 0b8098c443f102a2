#include <sys/ioctl.h>
#include <unistd.h>

#include <csignal>
#include <iostream>
#include <string>
#include <vector>

#include "client/command_line.h"

namespace {

int terminalWidth() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

int main(int argc, char** argv) {
    using namespace rivage::client;
    std::signal(SIGPIPE, SIG_IGN);
    std::ios::sync_with_stdio(false);
    Console console{std::cin,
                    std::cout,
                    std::cerr,
                    isatty(STDOUT_FILENO) == 1,
                    isatty(STDERR_FILENO) == 1,
                    terminalWidth()};
    const auto parsed = parseCommandLine(std::vector<std::string>(argv + 1, argv + argc), console);
    if (!parsed) return static_cast<int>(parsed.error());
    Interrupt interrupt;
    const SignalWatcher watcher(interrupt);
    return static_cast<int>(runCommand(*parsed, console, interrupt));
}
