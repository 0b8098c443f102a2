#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/load/units.h"
#include "proto/options.h"

namespace rivage::client::load {

enum class Mode : std::uint8_t {
    sync,  ///< POST /v1/regularize
    job,   ///< POST /v1/jobs, followed to its result
    get,   ///< a plain GET
};

/// How the client of a job learns of its end.
enum class Follow : std::uint8_t {
    events,  ///< GET /v1/jobs/{id}/events
    wait,    ///< GET /v1/jobs/{id} with Prefer: wait
    poll,    ///< GET /v1/jobs/{id} again and again
};

/// One kind of request of a mix.
struct MixEntry {
    std::string name;
    double weight = 1;
    Mode mode = Mode::sync;
    std::string sample;                      ///< the grid: a sample of the server, or ...
    std::string file;                        ///< ... a file
    std::vector<proto::OptionText> options;  ///< of the conversion
    std::string path;                        ///< of a plain GET
    Follow follow = Follow::events;
    std::chrono::milliseconds pollEvery{100};
    double abandoned = 0;                        ///< fraction of jobs whose client never comes back
    double cancelled = 0;                        ///< fraction of jobs that are cancelled ...
    std::chrono::milliseconds cancelAfter{100};  ///< ... so long after they were accepted
};

/// A condition that a run has to keep: at most `limit`, or at least, for goodput.
struct Threshold {
    std::string metric;  ///< "p99", "max", "errors", "refused", "not_sent", "goodput"
    double limit = 0;    ///< us for percentiles and max, a fraction, answers a second
};

/// What a run sends, and what it has to keep.
struct Mix {
    std::vector<MixEntry> entries;
    double duplicates = 0;  ///< fraction of conversions that may be answered from what is kept
    double aborts = 0;      ///< fraction of requests whose client leaves ...
    std::chrono::milliseconds abortAfter{50};  ///< ... within this time
    double slowClients = 0;                    ///< fraction of clients that send and read slowly
    double slowRate = 16384;                   ///< bytes a second of those
    std::optional<std::uint64_t> seed = {};
    std::optional<Slo> slo = {};
    std::vector<Threshold> thresholds = {};

    [[nodiscard]] std::vector<std::string> names() const;
};

/// Reads a mix. Nothing is ignored: an unknown member or a value out of range is refused.
/// @param where  what the text is called in messages
/// @errors usage, with the member as `field` (JSON pointer)
Outcome<Mix> parseMix(std::string_view text, const std::string& where);

/// The mix of who names none: the sample "island", converted in one request.
[[nodiscard]] Mix defaultMix();

/// A mix of nothing but `GET path`.
[[nodiscard]] Mix plainMix(const std::string& path);

}  // namespace rivage::client::load
