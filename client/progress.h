#pragma once

#include <chrono>
#include <string>

#include "client/console.h"
#include "client/conversion.h"

namespace rivage::client {

/// Shows how far one file is: a bar that redraws itself on a terminal, nothing elsewhere. `finish`
/// leaves one line behind in both cases; with `quiet` nothing is written at all.
class ProgressLine {
public:
    ProgressLine(Console& console, std::string name, bool quiet);

    void update(const JobProgress& progress);
    /// @param outcome  "-> out/house.glb, 93.1 kB"
    void finish(const std::string& outcome);
    /// Takes the bar away, for whoever writes next.
    void clear();
    [[nodiscard]] bool lively() const { return console_.errIsTerminal && !quiet_; }

private:
    [[nodiscard]] double seconds() const;
    Console& console_;
    std::string name_;
    bool quiet_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A number of bytes for a person: "812 B", "93.1 kB", "4.2 MB".
[[nodiscard]] std::string bytesText(double bytes);

}  // namespace rivage::client
