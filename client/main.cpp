#include <sys/ioctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/command_line.h"

namespace {

/// Columns and lines of the terminal behind stderr.
void measureTerminal(rivage::client::Console& console) {
    winsize size{};
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return;
    console.width = size.ws_col;
    console.height = size.ws_row;
}

bool isSet(const char* name) {
    const char* const value = std::getenv(name);
    return value != nullptr && *value != '\0';
}

bool isDumb() {
    const char* const terminal = std::getenv("TERM");
    return terminal == nullptr || std::string_view(terminal) == "dumb";
}

bool showsColor(const std::string& wish, bool terminal) {
    return wish == "always" || (wish == "auto" && terminal && !isSet("NO_COLOR"));
}

int run(int argc, char** argv) {
    using namespace rivage::client;
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // `ulimit -f` is an error of writing, not of the program
    std::ios::sync_with_stdio(false);
    Console console{std::cin, std::cout, std::cerr, isatty(STDOUT_FILENO) == 1,
                    isatty(STDERR_FILENO) == 1 && !isDumb()};
    console.inFile = STDIN_FILENO;
    measureTerminal(console);
    const auto parsed = parseCommandLine(std::vector<std::string>(argv + 1, argv + argc), console);
    if (!parsed) return static_cast<int>(parsed.error());
    console.color = showsColor(parsed->color, console.errIsTerminal);
    Interrupt interrupt;
    // What compares files has nothing to put in order, and ends by the signal itself.
    std::optional<SignalWatcher> watcher;
    if (parsed->command != Command::compare) watcher.emplace(interrupt);
    return static_cast<int>(runCommand(*parsed, console, interrupt));
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {  // such as memory that ran out
        std::cerr << "rivage: " << error.what() << "\n" << std::flush;
        return static_cast<int>(rivage::client::ExitCode::failed);
    }
}
