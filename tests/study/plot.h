#pragma once

#include <optional>
#include <string>
#include <vector>

/// Line plots with error bars, as SVG.
namespace rivage::study {

struct PlotPoint {
    double x;
    double y;
    double half = 0;  ///< of the error bar; NaN for none
};

struct PlotSeries {
    std::string name;  ///< the same method has the same colour in every plot
    std::vector<PlotPoint> points;
};

struct PlotPanel {
    std::string title;
    std::string xLabel;
    std::string yLabel;
    bool logX = false;
    bool logY = false;
    std::vector<PlotSeries> series;
    /// Thin lines y ~ x^-slope, through the last point of `studio`.
    std::vector<double> slopes = {};
    /// If any: x is 1, 2, ... for these, points stand side by side and are not joined.
    std::vector<std::string> categories = {};
};

/// Panels in rows of `columns`, two panels wide if there is one, with one legend above them. Points
/// that are not numbers, or not above 0 on a logarithmic axis, are left out.
[[nodiscard]] std::string drawPlot(const std::vector<PlotPanel>& panels, int columns);

}  // namespace rivage::study
