#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/study/metrics.h"

namespace rivage::study {

/// One run of one method on one grid.
struct Sample {
    std::string shape;
    int resolution = 0;  ///< of the grid along each axis
    int pose = 0;
    std::string method;
    double level = 0;  ///< of the disturbance that the section is about
    Measures measures;
    double milliseconds = 0;  ///< of one thread; kept in a file of its own
};
using Samples = std::vector<Sample>;

/// Writes `SECTION.csv`, the same bytes in every run, and `SECTION.times.csv`.
/// @return false if a file cannot be written
bool writeSamples(const std::filesystem::path& folder, const std::string& section,
                  const Samples& samples);

/// Reads what `writeSamples` wrote.
/// @return nothing if the section has not been measured
std::optional<Samples> readSamples(const std::filesystem::path& folder, const std::string& section);

}  // namespace rivage::study
