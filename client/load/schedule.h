#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "client/failure.h"

namespace rivage::client::load {

using Nanoseconds = std::chrono::nanoseconds;

/// When a request is due, and what it is.
struct Arrival {
    Nanoseconds at{0};  ///< from the start; `kNever` if there is none any more
    int entry = -1;     ///< of the mix; -1: drawn by weight
};

inline constexpr Nanoseconds kNever = Nanoseconds::max();

enum class Arrivals : std::uint8_t { closed, constant, poisson, replay };

[[nodiscard]] const char* nameOf(Arrivals arrivals);

/// How requests arrive in a run.
struct ArrivalPlan {
    Arrivals kind = Arrivals::closed;
    double rate = 0;             ///< requests a second, of all threads
    int concurrency = 1;         ///< requests in flight of the closed loop
    std::vector<Arrival> trace;  ///< of a replay, by rising time
};

/// The arrivals that one of several threads has to send; together the threads send them all.
class Schedule {
public:
    /// @param plan  must outlive the schedule; not a closed loop
    Schedule(const ArrivalPlan& plan, int thread, int threads, std::uint64_t seed);
    [[nodiscard]] Arrival next();

private:
    const ArrivalPlan& plan_;
    std::uint64_t step_;
    std::uint64_t number_;  ///< of the next arrival, over all threads
    double seconds_ = 0;    ///< of the last arrival of a Poisson process
    std::mt19937_64 random_;
};

/// Reads a trace: in each line the seconds of a request, and after a comma the name of an entry of
/// the mix if it is not to be drawn. Empty lines and what follows '#' do not count. The first
/// request is sent at once.
/// @param entries  the names of the mix
/// @errors usage, naming the line
Outcome<std::vector<Arrival>> parseTrace(std::string_view text,
                                         const std::vector<std::string>& entries);

}  // namespace rivage::client::load
