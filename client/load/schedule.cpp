#include "client/load/schedule.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace rivage::client::load {
namespace {

Nanoseconds toNanoseconds(double seconds) {
    return seconds > 9e9 ? kNever : Nanoseconds(std::llround(seconds * 1e9));
}

std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

tl::unexpected<Failure> badLine(int line, const std::string& why) {
    return fail(ExitCode::usage, "The trace cannot be read",
                "line " + std::to_string(line) + ": " + why);
}

/// Reads one line that is not empty.
Outcome<Arrival> parseLine(std::string_view text, int line,
                           const std::vector<std::string>& entries) {
    const std::size_t comma = text.find(',');
    const std::string_view time = trimmed(text.substr(0, comma));
    double seconds = 0;
    const auto [end, error] = std::from_chars(time.data(), time.data() + time.size(), seconds);
    if (error != std::errc() || end != time.data() + time.size() || !std::isfinite(seconds) ||
        std::abs(seconds) > 4e9)
        return badLine(line, proto::inQuotes(time) + " is no number of seconds");
    Arrival arrival{toNanoseconds(seconds), -1};
    if (comma == std::string_view::npos) return arrival;
    const std::string_view name = trimmed(text.substr(comma + 1));
    const auto entry = std::find(entries.begin(), entries.end(), name);
    if (entry == entries.end())
        return badLine(line, "the mix has no entry " + proto::inQuotes(name));
    arrival.entry = static_cast<int>(entry - entries.begin());
    return arrival;
}

}  // namespace

const char* nameOf(Arrivals arrivals) {
    switch (arrivals) {
        case Arrivals::closed: return "closed loop";
        case Arrivals::constant: return "open loop, constant rate";
        case Arrivals::poisson: return "open loop, Poisson";
        case Arrivals::replay: return "open loop, replay";
    }
    return "";
}

Schedule::Schedule(const ArrivalPlan& plan, int thread, int threads, std::uint64_t seed)
    : plan_(plan),
      step_(static_cast<std::uint64_t>(threads)),
      number_(static_cast<std::uint64_t>(thread)),
      random_(seed) {}

Arrival Schedule::next() {
    const std::uint64_t number = number_;
    number_ += step_;
    if (plan_.kind == Arrivals::replay)
        return number < plan_.trace.size() ? plan_.trace[number] : Arrival{kNever};
    if (plan_.kind == Arrivals::constant)
        return {toNanoseconds(static_cast<double>(number) / plan_.rate)};
    // Independent Poisson processes add up to one with the sum of their rates.
    std::exponential_distribution<double> gap(plan_.rate / static_cast<double>(step_));
    seconds_ += gap(random_);
    return {toNanoseconds(seconds_)};
}

Outcome<std::vector<Arrival>> parseTrace(std::string_view text,
                                         const std::vector<std::string>& entries) {
    std::vector<Arrival> trace;
    for (int line = 1; !text.empty(); ++line) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view words = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        words = trimmed(words.substr(0, words.find('#')));
        if (words.empty()) continue;
        const auto arrival = parseLine(words, line, entries);
        if (!arrival) return tl::unexpected(arrival.error());
        if (!trace.empty() && arrival->at < trace.back().at)
            return badLine(line, "the times must rise");
        trace.push_back(*arrival);
    }
    if (trace.empty())
        return fail(ExitCode::usage, "The trace cannot be read", "it has no request");
    const Nanoseconds first = trace.front().at;
    for (Arrival& arrival : trace) arrival.at -= first;
    return trace;
}

}  // namespace rivage::client::load
