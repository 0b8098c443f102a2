#include "tests/study/plot.h"
#include "tests/study/report.h"
#include "tests/study/view.h"

namespace rivage::study {
namespace {

using Names = std::vector<std::string>;

PlotPanel levelPanel(const View& view, const std::string& shape, const Names& methods,
                     Measure measure, const std::string& xLabel) {
    PlotPanel panel{shape.empty() ? "all shapes" : shape, xLabel,
                    measure == Measure::rms ? "rms distance, voxels" : "normal error, degrees"};
    panel.logY = measure == Measure::rms;
    for (const std::string& method : methods)
        panel.series.push_back(
            view.overLevels({.shape = shape, .method = method, .measure = measure}));
    return panel;
}

/// All shapes, a smooth one, a creased one and one with several labels: distances, then normals.
std::string noisePlot(const View& view, const Names& methods, const std::string& xLabel) {
    const Names shapes = {"", "sphere", "box", "sectors"};
    std::vector<PlotPanel> panels;
    for (const Measure measure : {Measure::rms, Measure::normalMean})
        for (const std::string& shape : shapes)
            panels.push_back(levelPanel(view, shape, methods, measure, xLabel));
    return drawPlot(panels, 4);
}

/// Shapes side by side.
PlotPanel shapePanel(const View& view, Measure measure, const std::string& title) {
    PlotPanel panel{title, "", measure == Measure::rms ? "voxels" : "degrees"};
    panel.logY = true;
    panel.categories = view.shapes();
    for (const std::string& method : view.methods()) {
        PlotSeries series{method, {}};
        for (std::size_t i = 0; i < panel.categories.size(); ++i) {
            const Interval mean =
                view.mean({.shape = panel.categories[i], .method = method, .measure = measure});
            series.points.push_back({static_cast<double>(i + 1), mean.mean, mean.half});
        }
        panel.series.push_back(std::move(series));
    }
    return panel;
}

std::string convergencePlot(const View& view, Measure measure, double exponent,
                            const std::string& yLabel, const std::vector<double>& slopes) {
    std::vector<PlotPanel> panels;
    for (const std::string& shape : view.shapes()) {
        PlotPanel panel{shape, "N = 1/h", yLabel, true, true};
        for (const std::string& method : view.methods())
            panel.series.push_back(view.overResolutions(
                {.shape = shape, .method = method, .measure = measure}, exponent));
        panel.slopes = slopes;
        panels.push_back(std::move(panel));
    }
    return drawPlot(panels, 2);
}

std::string speedPlot(const View& view) {
    PlotPanel degrees{"normals", "steps", "degrees from the minimum", false, true};
    PlotPanel voxels{"vertices", "steps", "voxels (rms) from the minimum", false, true};
    for (const char* method : {"gradient descent", "accelerated"}) {
        degrees.series.push_back(
            view.overLevels({.method = method, .measure = Measure::normalMean}));
        voxels.series.push_back(view.overLevels({.method = method, .measure = Measure::rms}));
    }
    return drawPlot({degrees, voxels}, 2);
}

}  // namespace

std::map<std::string, std::string> drawPlots(const Measured& measured) {
    const Names noise = {"raw",    "MC",   "DC", "DC in cell", "SN", "SN 16", "paper, auto normals",
                         "studio", "noisy"};
    std::map<std::string, std::string> plots;
    for (const auto& [section, samples] : measured) {
        const View view(samples);
        if (section == "shapes")
            plots["shapes"] = drawPlot({shapePanel(view, Measure::rms, "rms distance"),
                                        shapePanel(view, Measure::normalMean, "normal error")},
                                       1);
        if (section == "creases")
            plots["creases"] =
                drawPlot({shapePanel(view, Measure::nearCrease, "1 to 3 voxels from a crease"),
                          shapePanel(view, Measure::farCrease, "farther away")},
                         1);
        if (section == "normal-noise")
            plots[section] = noisePlot(view, noise, "tilt of the normals, degrees");
        if (section == "position-noise")
            plots[section] = noisePlot(view, noise, "noise of the positions, voxels");
        if (section == "label-noise") plots[section] = noisePlot(view, noise, "k");
        if (section == "speed") plots["speed"] = speedPlot(view);
        if (section != "convergence") continue;
        plots["convergence-distance"] =
            convergencePlot(view, Measure::rms, -1, "rms distance, object units", {1});
        plots["convergence-normals"] =
            convergencePlot(view, Measure::normalMean, 0, "normal error, degrees", {0.5, 1});
    }
    return plots;
}

}  // namespace rivage::study
