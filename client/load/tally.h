#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "client/load/histogram.h"

namespace rivage::client::load {

/// What is measured, each in a histogram of its own.
enum class Measure : std::uint8_t {
    corrected,  ///< good answers, from the planned send
    asSent,     ///< good answers, from the actual send
    service,    ///< good answers, from the connection that stands
    lag,        ///< of all requests, from the planned to the actual send
    refused,    ///< 429 and 503, from the planned send
    connect,    ///< phases of an exchange
    tls,
    upload,
    wait,
    download,
    serverQueue,  ///< by Server-Timing
    serverCompute,
    serverOverhead,  ///< service time less both
    jobResult,       ///< from the submission of a job to the last byte of its result
    jobFirstEvent,   ///< from the request for events to the first
    jobCancel,       ///< from DELETE to the end of the job
    slow,            ///< good answers to clients that are slow on purpose, as sent
};
inline constexpr std::size_t kMeasures = 17;

[[nodiscard]] const char* nameOf(Measure measure);
/// All measures, in their order.
[[nodiscard]] std::vector<Measure> allMeasures();

/// How requests of one entry of the mix ended.
struct EntryTally {
    std::uint64_t planned = 0;
    std::uint64_t good = 0;
    Histogram corrected;
};

/// How the requests of a run ended. Each that was planned is counted in exactly one of good,
/// refused, failed, aborted, abandoned, cancelled and slow.
struct Tally {
    std::uint64_t planned = 0;
    std::uint64_t sent = 0;       ///< planned ones that got a connection or the attempt of one
    std::uint64_t good = 0;       ///< 2xx, whole
    std::uint64_t withinSlo = 0;  ///< good ones within the limit, from the planned send
    std::uint64_t refused = 0;    ///< 429 and 503
    std::uint64_t failed = 0;     ///< every other error, by class in `errors`
    std::uint64_t aborted = 0;    ///< left on purpose
    std::uint64_t abandoned = 0;  ///< jobs whose client never came back, on purpose
    std::uint64_t cancelled = 0;  ///< jobs that were cancelled, on purpose
    std::uint64_t slow = 0;       ///< of clients that are slow on purpose
    std::uint64_t late = 0;       ///< sent later than a healthy generator would have
    std::uint64_t retried = 0;    ///< on a new connection, as the old one had just been closed
    std::uint64_t jobs = 0;       ///< that ended with a result
    std::uint64_t polls = 0;      ///< requests for their state
    std::array<Histogram, kMeasures> times;
    std::map<std::string, std::uint64_t> errors;  ///< by class, with refusals
    std::map<int, std::uint64_t> statuses;
    std::vector<EntryTally> entries;

    Histogram& operator[](Measure measure) { return times[static_cast<std::size_t>(measure)]; }
    const Histogram& operator[](Measure measure) const {
        return times[static_cast<std::size_t>(measure)];
    }
    void merge(const Tally& other);
    [[nodiscard]] std::uint64_t notSent() const;
    /// Those that were no part of the experiment on clients that leave.
    [[nodiscard]] std::uint64_t judged() const { return good + refused + failed; }
    /// The share of `judged` that was refused or failed.
    [[nodiscard]] double errorRate() const;
};

/// What ended within one second.
struct Second {
    std::uint64_t sent = 0;
    std::uint64_t good = 0;
    std::uint64_t withinSlo = 0;
    std::uint64_t refused = 0;
    std::uint64_t failed = 0;
    std::uint64_t bytesIn = 0;
    std::vector<Histogram::Bucket> corrected;  ///< of the good answers; a bucket may come twice
    std::vector<Histogram::Bucket> asSent;

    void merge(const Second& other);
    [[nodiscard]] Histogram latency() const;
};

/// The seconds of a run, from several threads.
class Series {
public:
    void add(std::size_t second, const Second& part);
    [[nodiscard]] std::vector<Second> all() const;
    [[nodiscard]] std::size_t size() const;
    /// The seconds from `begin` to before `end` as one.
    [[nodiscard]] Second between(std::size_t begin, std::size_t end) const;

private:
    mutable std::mutex mutex_;
    std::vector<Second> seconds_;
};

}  // namespace rivage::client::load
