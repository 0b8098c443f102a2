#pragma once

#include <string>
#include <utility>
#include <vector>

#include "client/load/run.h"

namespace rivage::client::load {

/// One line of a plot.
struct PlotLine {
    std::string name;
    std::string colour;
    std::vector<std::pair<double, double>> points;
};

/// One pair of axes; y is logarithmic, in us, with times as marks.
struct PlotPanel {
    std::string title;
    std::vector<PlotLine> lines;
    std::vector<std::pair<double, std::string>> marks;  ///< of the x axis
};

/// Panels below each other, as SVG.
[[nodiscard]] std::string drawSvg(const std::vector<PlotPanel>& panels);

/// The percentiles of the latency, from the planned and from the actual send, and the latency
/// second by second.
[[nodiscard]] std::string drawLatency(const LoadResult& result);

}  // namespace rivage::client::load
