#pragma once

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "client/command_line.h"

namespace rivage::client {

/// One run of the program inside this process.
struct Run {
    std::istringstream in;
    std::ostringstream out;
    std::ostringstream err;
    ExitCode code = ExitCode::ok;
    Interrupt interrupt;
    bool outIsTerminal = false;
    RetryPolicy retry{.base = std::chrono::milliseconds(1), .cap = std::chrono::milliseconds(5)};

    explicit Run(std::string input = {}) : in(std::move(input)) {
        setenv("RIVAGE_CONFIG", "/dev/null", 0);  // not that of whoever runs the tests
    }

    Run& operator()(const std::vector<std::string>& arguments) {
        Console console{in, out, err, outIsTerminal};
        auto invocation = parseCommandLine(arguments, console);
        if (!invocation) {
            code = invocation.error();
            return *this;
        }
        invocation->retry = retry;
        code = runCommand(*invocation, console, interrupt);
        return *this;
    }
};

inline std::string contentOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline void writeFile(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

}  // namespace rivage::client
