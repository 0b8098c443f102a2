#include "client/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace rivage::client {
namespace {

constexpr const char* kEraseLine = "\r\x1b[K";
constexpr int kWidestBar = 40;

std::string fixed(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

std::string bar(double fraction, int width) {
    const auto full = static_cast<std::size_t>(std::lround(fraction * width));
    std::string text(full, '#');
    text.resize(static_cast<std::size_t>(width), '.');
    return "[" + text + "]";
}

std::string phase(const JobProgress& progress) {
    if (progress.state != "queued") return progress.stage.empty() ? progress.state : progress.stage;
    if (!progress.queuePosition || *progress.queuePosition == 0) return "queued";
    return "queued behind " + fixed(*progress.queuePosition, 0);
}

}  // namespace

ProgressLine::ProgressLine(Console& console, std::string name, bool quiet)
    : console_(console), name_(std::move(name)), quiet_(quiet) {}

double ProgressLine::seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void ProgressLine::update(const JobProgress& progress) {
    if (!lively()) return;
    const double fraction = std::clamp(progress.fraction, 0.0, 1.0);
    const std::string words =
        " " + fixed(100 * fraction, 0) + " % " + phase(progress) + " " + fixed(seconds(), 1) + " s";
    const int left = console_.width - static_cast<int>(name_.size() + words.size()) - 4;
    std::string line = name_ + words;
    if (left >= 8) line = name_ + " " + bar(fraction, std::min(left, kWidestBar)) + words;
    line.resize(std::min(line.size(), static_cast<std::size_t>(std::max(console_.width - 1, 1))));
    console_.err << kEraseLine << line << std::flush;
}

void ProgressLine::clear() {
    if (lively()) console_.err << kEraseLine << std::flush;
}

void ProgressLine::finish(const std::string& outcome) {
    clear();
    if (!quiet_) console_.err << name_ << " " << outcome << ", " << fixed(seconds(), 2) << " s\n";
}

std::string bytesText(double bytes) {
    if (bytes < 1e3) return fixed(bytes, 0) + " B";
    if (bytes < 1e6) return fixed(bytes / 1e3, 1) + " kB";
    return fixed(bytes / 1e6, 1) + " MB";
}

}  // namespace rivage::client
