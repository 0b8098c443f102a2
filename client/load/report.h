#pragma once

#include <string>
#include <vector>

#include "client/load/verdict.h"

namespace rivage::client::load {

/// A run with everything that is said about it.
struct LoadReport {
    const LoadPlan& plan;
    const LoadResult& result;
    std::vector<Judgement> judgements;
    proto::Json environment;
    proto::Json server;  ///< its answer to /version, or null
};

/// "open loop, constant rate 200/s, 10 s after 1 s of warm-up".
[[nodiscard]] std::string describeLoad(const LoadPlan& plan);

/// What a person wants to know, in a few lines.
[[nodiscard]] std::string reportTable(const LoadReport& report);

/// What the exit code comes from, a line each: "INVALID: ...", "MISSED   ...", "kept     ...".
[[nodiscard]] std::vector<std::string> verdictLines(const LoadReport& report);

/// Everything, with the histograms without loss.
[[nodiscard]] proto::Json reportJson(const LoadReport& report);

/// The table as Markdown, with the environment.
[[nodiscard]] std::string reportMarkdown(const LoadReport& report);

/// One line a second: what ended, percentiles, and what the server said of itself.
[[nodiscard]] std::string reportCsv(const LoadReport& report);

/// The percentiles that are told: 50, 90, 95, 99, 99.9, 99.99.
[[nodiscard]] const std::vector<double>& toldPercentiles();

/// "503-shed busy x12, timeout x1".
[[nodiscard]] std::string errorList(const Tally& tally);

}  // namespace rivage::client::load
