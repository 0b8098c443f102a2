#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/load/run.h"

namespace rivage::client::load {

/// How a run of `rivage-load` ended, for scripts (README.md). Where a code of `rivage` means the
/// same it has the same number; 1 and 3 are of load tests only.
enum class LoadExit : std::uint8_t {
    ok = 0,
    missed = 1,       ///< a threshold or the limit of --slo was not kept, or nothing was good
    usage = 2,        ///< the command line, the mix or the trace is wrong
    late = 3,         ///< the generator did not keep up: the figures say nothing
    unreachable = 4,  ///< no server answers
    cancelled = 7,
    notWritten = 8,
};

/// What a failure of the client's means here: a server that refuses what a mix asks for has been
/// given a wrong mix.
[[nodiscard]] LoadExit exitOf(const Failure& failure);

/// One condition and what came of it.
struct Judgement {
    Threshold threshold;
    std::optional<double> actual;  ///< nothing: there were too few samples to say
    bool kept = false;             ///< too few samples do not keep a condition
};

/// @param slo  judged like a threshold, after the others
[[nodiscard]] std::vector<Judgement> judge(const std::vector<Threshold>& thresholds,
                                           const std::optional<Slo>& slo, const LoadResult& result);

/// "p99 = 31.2 ms, at most 500 ms".
[[nodiscard]] std::string describe(const Judgement& judgement);

/// Why a run without any condition is none that kept it: there is nothing to judge, or nothing
/// good. Empty if there is, or if more is wrong.
[[nodiscard]] std::string whatIsMissing(const LoadResult& result);

/// The exit code of a run: a generator that was late comes before everything that it measured.
[[nodiscard]] LoadExit exitOf(const LoadResult& result, const std::vector<Judgement>& judgements);

}  // namespace rivage::client::load
