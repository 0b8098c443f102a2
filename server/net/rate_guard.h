#pragma once

#include <chrono>
#include <cstdint>

#include "server/net/limits.h"

namespace rivage::server {

using NetClock = std::chrono::steady_clock;

/// Finds transfers that are too slow: in each window of time, so many bytes must pass. A window,
/// not an average from the start: a fast beginning must not pay for a long silence.
class RateGuard {
public:
    /// @param window      length of a window, which is also the grace at the start
    /// @param rate        least bytes per second
    /// @param transferred bytes until now, in the count that `tooSlow` is given later
    RateGuard(NetLimits::Time window, std::uint64_t rate, NetClock::time_point now,
              std::int64_t transferred)
        : window_(window),
          needed_(
              static_cast<std::int64_t>(rate * static_cast<std::uint64_t>(window.count()) / 1000)),
          end_(now + window),
          base_(transferred) {}

    /// When to ask again.
    [[nodiscard]] NetClock::time_point windowEnd() const { return end_; }

    /// Whether a window has passed with too few bytes; else begins the next if one has passed.
    bool tooSlow(NetClock::time_point now, std::int64_t transferred) {
        if (now < end_) return false;
        if (transferred - base_ < needed_) return true;
        end_ = now + window_;
        base_ = transferred;
        return false;
    }

private:
    NetLimits::Time window_;
    std::int64_t needed_;
    NetClock::time_point end_;
    std::int64_t base_;
};

}  // namespace rivage::server
