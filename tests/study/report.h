#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "tests/study/samples.h"

/// RESULTS.md and its plots, from the samples alone.
namespace rivage::study {

/// What the report says about the run itself.
struct RunFacts {
    std::string commit;
    std::map<std::string, double> seconds;  ///< of each section
    int threads = 1;
    int cores = 1;
    double load = 0;  ///< of the machine, the mean of the last 15 minutes
};

/// Samples by section; sections that were not measured are missing.
using Measured = std::map<std::string, Samples>;

/// The whole of RESULTS.md.
[[nodiscard]] std::string writeReport(const Measured& measured, const RunFacts& facts);

/// Name and text of each plot that the report shows.
[[nodiscard]] std::map<std::string, std::string> drawPlots(const Measured& measured);

/// The section of the verdicts: each claim, its figure, and whether that is within its threshold.
[[nodiscard]] std::string writeVerdicts(const Measured& measured);

}  // namespace rivage::study
