#include "client/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/printable.h"

namespace rivage::client {
namespace {

constexpr const char* kEraseBelow = "\r\x1b[J";
constexpr int kWidestBar = 40;
constexpr int kNarrowestBar = 8;
constexpr int kMostLines = 10;
/// Room for the longest words beside a bar, so that it does not change its width as they do.
constexpr int kWordsWidth = 42;

std::string formatted(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string bar(double fraction, int width) {
    const auto full = static_cast<std::size_t>(std::lround(fraction * width));
    std::string text(full, '#');
    text.resize(static_cast<std::size_t>(width), '.');
    return "[" + text + "]";
}

/// The end of a name that is too long: of a path, the file.
std::string shortened(const std::string& name, int most) {
    const auto kept = static_cast<std::size_t>(std::max(most - 3, 8));
    if (name.size() <= kept + 3) return name;
    std::size_t from = name.size() - kept;
    while (from < name.size() && (name[from] & 0xC0) == 0x80) ++from;  // not inside a character
    return "..." + name.substr(from);
}

std::string phase(const JobProgress& progress) {
    if (progress.state.empty()) return "sending";
    if (progress.state != "queued") {
        std::string text = printable(progress.stage.empty() ? progress.state : progress.stage);
        if (progress.energy) text += formatted(", energy %.5g", *progress.energy);
        return text;
    }
    if (!progress.queuePosition || *progress.queuePosition == 0) return "queued";
    return "queued behind " + countText(*progress.queuePosition);
}

/// Within 0 and 1, also what is no number.
double within(double share) { return share > 0 ? std::min(share, 1.0) : 0; }

}  // namespace

ProgressBoard::ProgressBoard(Console& console, bool quiet, std::size_t total)
    : console_(console), lively_(console.errIsTerminal && !quiet), total_(total) {}

ProgressBoard::~ProgressBoard() {
    const std::lock_guard lock(mutex_);
    erase();
    console_.err << std::flush;
}

std::size_t ProgressBoard::begin(const std::string& name) {
    const std::lock_guard lock(mutex_);
    lines_[begun_] = {.name = printable(name)};
    erase();
    draw();
    return begun_++;
}

void ProgressBoard::update(std::size_t line, const JobProgress& progress) {
    const std::lock_guard lock(mutex_);
    lines_.at(line).progress = progress;
    erase();
    draw();
}

double ProgressBoard::end(std::size_t line) {
    const std::lock_guard lock(mutex_);
    const std::chrono::duration<double> time = Clock::now() - lines_.at(line).start;
    lines_.erase(line);
    ++ended_;
    erase();
    draw();
    return time.count();
}

void ProgressBoard::say(std::ostream& stream, const std::string& text) {
    const std::lock_guard lock(mutex_);
    erase();
    console_.err << std::flush;
    stream << text << std::flush;
    draw();
}

void ProgressBoard::erase() {
    if (drawn_ == 0) return;
    if (drawn_ > 1) console_.err << "\x1b[" << drawn_ - 1 << "A";
    console_.err << kEraseBelow;
    drawn_ = 0;
}

void ProgressBoard::draw() {
    if (!lively_ || lines_.empty()) return;
    const int most = std::clamp(console_.height - 2, 1, kMostLines);
    std::string all;
    if (total_ > 1) {
        all = std::to_string(ended_) + " of " + std::to_string(total_) + " done";
        all = painted(console_, Tone::dim, all);
        ++drawn_;
    }
    for (const auto& [number, line] : lines_) {
        if (drawn_ >= most) break;
        all += (drawn_ > 0 ? "\n" : "") + text(line);
        ++drawn_;
    }
    console_.err << all << std::flush;
}

std::string ProgressBoard::text(const Line& line) const {
    const double fraction = within(line.progress.fraction);
    const std::chrono::duration<double> time = Clock::now() - line.start;
    const std::string words = " " + percentText(fraction) + " " + phase(line.progress) +
                              formatted(" %.1f s", time.count());
    const std::string name = shortened(line.name, console_.width / 3);
    const int left = console_.width - static_cast<int>(name.size()) - kWordsWidth;
    std::string text = name;
    if (left >= kNarrowestBar) text += " " + bar(fraction, std::min(left, kWidestBar));
    text += words;
    // A line that wraps would be two, and could not be erased as one.
    return cutTo(text, static_cast<std::size_t>(std::max(console_.width - 1, 1)));
}

std::string percentText(double share) { return formatted("%.0f %%", 100 * within(share)); }

std::string countText(double count) {
    return formatted(std::abs(count) < 1e9 ? "%.0f" : "%.0e", count);
}

std::string bytesText(double bytes) {
    if (bytes < 1e3) return formatted("%.0f B", bytes);
    if (bytes < 1e6) return formatted("%.1f kB", bytes / 1e3);
    return formatted(bytes < 1e15 ? "%.1f MB" : "%.0e MB", bytes / 1e6);
}

std::string secondsText(double seconds) { return formatted("%.2f s", seconds); }

}  // namespace rivage::client
