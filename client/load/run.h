#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/load/generator.h"
#include "client/load/metrics_poll.h"

namespace rivage::client::load {

/// Whether the generator kept up: if not, the figures are about it and not about the server.
struct GeneratorHealth {
    double lateShare = 0;  ///< of the sends
    double cpu = 0;        ///< of the busiest thread, 0..1
    std::uint64_t notSent = 0;
    double loadAverage = 0;  ///< of the last minute, at the end; 0: not known
    Shortage shortage;       ///< of files, ports, memory
    bool valid = true;
    std::string reason;  ///< why not
};

/// What came of a run.
struct LoadResult {
    Tally tally;
    std::vector<Second> seconds;
    double duration = 0;  ///< s, measured
    std::uint64_t connections = 0;
    std::uint64_t bytesIn = 0;  ///< with the warm-up
    std::uint64_t bytesOut = 0;
    std::uint64_t verified = 0;
    std::uint64_t unverified = 0;  ///< drawn, but there was no time to look
    GeneratorHealth health;
    std::vector<MetricsSample> metrics;  ///< each second of the whole run
    bool interrupted = false;

    /// Good answers within the limit and not found wrong, a second.
    [[nodiscard]] double goodput() const;
    [[nodiscard]] double offered() const;
};

/// Called about four times a second with what has ended so far. @return false to end the run
using LoadObserver = std::function<bool(const Series& series)>;

/// Runs a plan to its end, or until somebody wants it to end.
LoadResult runLoad(const LoadPlan& plan, Interrupt& interrupt, const LoadObserver& observe = {},
                   const std::optional<ServerAccess>& admin = {});

/// Whether the generator had all that it needed, and was not late by the rule of 1 %.
/// @param seen  its processor, load and shortage
[[nodiscard]] GeneratorHealth judgeHealth(const LoadPlan& plan, const Tally& tally,
                                          const GeneratorHealth& seen);

}  // namespace rivage::client::load
