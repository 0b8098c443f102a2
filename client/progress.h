#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>

#include "client/console.h"
#include "client/job_calls.h"

namespace rivage::client {

/// Shows how far the files of a run are: on a terminal one bar each, and above them how many are
/// done, redrawn in place; elsewhere nothing. What is said goes above the bars and stays. All that
/// is written while it lives goes through it, from any thread; with `quiet` it shows no bars.
class ProgressBoard {
public:
    /// @param total  files of the run
    ProgressBoard(Console& console, bool quiet, std::size_t total);
    ~ProgressBoard();
    ProgressBoard(const ProgressBoard&) = delete;
    ProgressBoard& operator=(const ProgressBoard&) = delete;

    /// A bar for a file; the number to name it by.
    std::size_t begin(const std::string& name);
    void update(std::size_t line, const JobProgress& progress);
    /// Takes a bar away.
    /// @return  the seconds since `begin`
    double end(std::size_t line);
    /// Writes to a stream of the console, above the bars.
    void say(std::ostream& stream, const std::string& text);

    [[nodiscard]] bool lively() const { return lively_; }

private:
    using Clock = std::chrono::steady_clock;
    struct Line {
        std::string name;
        JobProgress progress;
        Clock::time_point start = Clock::now();
    };
    void erase();
    void draw();
    [[nodiscard]] std::string text(const Line& line) const;

    Console& console_;
    const bool lively_;
    const std::size_t total_;
    std::mutex mutex_;
    std::map<std::size_t, Line> lines_;
    std::size_t begun_ = 0;
    std::size_t ended_ = 0;
    int drawn_ = 0;  ///< lines on the terminal
};

/// A share of 0 to 1 in percent, "42 %"; what is beyond, or no number, becomes the nearer end.
[[nodiscard]] std::string percentText(double share);

/// A count of a server, of which there is no telling how large it is: "3", "1e+300".
[[nodiscard]] std::string countText(double count);

/// A number of bytes for a person: "812 B", "93.1 kB", "4.2 MB".
[[nodiscard]] std::string bytesText(double bytes);

/// "0.52 s"
[[nodiscard]] std::string secondsText(double seconds);

}  // namespace rivage::client
