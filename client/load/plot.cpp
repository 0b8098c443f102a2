#include "client/load/plot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/load/units.h"
#include "client/printable.h"

namespace rivage::client::load {
namespace {

constexpr double kWidth = 860;
constexpr double kPanel = 320;  // height of a panel, with its title and marks
constexpr double kLeft = 80;
constexpr double kRight = 20;
constexpr double kTop = 40;
constexpr double kBottom = 40;

/// Where values lie in a panel.
struct Scale {
    double x0 = std::numeric_limits<double>::max();
    double x1 = std::numeric_limits<double>::lowest();
    double low = std::numeric_limits<double>::max();  ///< of log10(y)
    double high = std::numeric_limits<double>::lowest();
    double top = 0;

    [[nodiscard]] double x(double value) const {
        return kLeft + (value - x0) / (x1 - x0) * (kWidth - kLeft - kRight);
    }
    [[nodiscard]] double y(double value) const {
        const double share = (std::log10(std::max(value, 1.0)) - low) / (high - low);
        return top + kPanel - kBottom - share * (kPanel - kTop - kBottom);
    }
};

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : printable(text))
        result += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    return result;
}

std::string textAt(double x, double y, const std::string& anchor, const std::string& text,
                   const std::string& colour = "#333") {
    return "<text x=\"" + numberText(x, 1) + "\" y=\"" + numberText(y, 1) + "\" text-anchor=\"" +
           anchor + "\" fill=\"" + colour + "\">" + escaped(text) + "</text>\n";
}

std::string rule(double x1, double y1, double x2, double y2) {
    return "<line x1=\"" + numberText(x1, 1) + "\" y1=\"" + numberText(y1, 1) + "\" x2=\"" +
           numberText(x2, 1) + "\" y2=\"" + numberText(y2, 1) + "\" stroke=\"#ddd\"/>\n";
}

Scale scaleOf(const PlotPanel& panel, double top) {
    Scale scale;
    scale.top = top;
    for (const PlotLine& line : panel.lines)
        for (const auto& [x, y] : line.points) {
            scale.x0 = std::min(scale.x0, x);
            scale.x1 = std::max(scale.x1, x);
            scale.low = std::min(scale.low, std::log10(std::max(y, 1.0)));
            scale.high = std::max(scale.high, std::log10(std::max(y, 1.0)));
        }
    if (scale.x0 > scale.x1) return {0, 1, 0, 1, top};
    if (scale.x1 == scale.x0) scale.x1 = scale.x0 + 1;
    scale.low = std::floor(scale.low);
    scale.high = std::max(scale.low + 1, std::ceil(scale.high));
    return scale;
}

std::string drawAxes(const PlotPanel& panel, const Scale& scale) {
    const double bottom = scale.top + kPanel - kBottom;
    std::string svg = textAt(kLeft, scale.top + 20, "start", panel.title);
    const int last = static_cast<int>(scale.high);
    for (int decade = static_cast<int>(scale.low); decade <= last; ++decade) {
        const double value = std::pow(10, decade);
        svg += rule(kLeft, scale.y(value), kWidth - kRight, scale.y(value));
        svg += textAt(kLeft - 8, scale.y(value) + 4, "end",
                      timeText(static_cast<std::int64_t>(value)));
    }
    for (const auto& [x, name] : panel.marks) {
        if (x < scale.x0 || x > scale.x1) continue;
        svg += rule(scale.x(x), scale.top + kTop, scale.x(x), bottom);
        svg += textAt(scale.x(x), bottom + 18, "middle", name);
    }
    return svg;
}

std::string drawPanel(const PlotPanel& panel, double top) {
    const Scale scale = scaleOf(panel, top);
    std::string svg = drawAxes(panel, scale);
    double legend = kWidth - kRight;
    for (const PlotLine& line : panel.lines) {
        svg +=
            "<polyline fill=\"none\" stroke-width=\"2\" stroke=\"" + line.colour + "\" points=\"";
        for (const auto& [x, y] : line.points)
            svg += numberText(scale.x(x), 1) + "," + numberText(scale.y(y), 1) + " ";
        svg += "\"/>\n" + textAt(legend, top + 20, "end", line.name, line.colour);
        legend -= 9 * static_cast<double>(line.name.size()) + 16;
    }
    return svg;
}

/// Percentiles, evenly spread over the number of nines.
std::vector<std::pair<double, double>> spectrum(const Histogram& histogram) {
    std::vector<std::pair<double, double>> points;
    if (histogram.count() == 0) return points;
    const double nines = std::log10(static_cast<double>(histogram.count()));
    constexpr double kStep = 0.02;
    for (int i = 0; i * kStep <= nines; ++i) {
        const double percent = 100 * (1 - std::pow(10, -i * kStep));
        points.emplace_back(i * kStep, static_cast<double>(histogram.valueAt(percent)));
    }
    points.emplace_back(nines, static_cast<double>(histogram.max()));
    return points;
}

PlotPanel timeline(const LoadResult& result) {
    PlotPanel panel{"latency by second, from the planned send", {}, {}};
    PlotLine median{"p50", "#1f77b4", {}};
    PlotLine high{"p99", "#ff7f0e", {}};
    PlotLine most{"max", "#d62728", {}};
    for (std::size_t i = 0; i < result.seconds.size(); ++i) {
        const Histogram latency = result.seconds[i].latency();
        if (latency.count() == 0) continue;
        const auto x = static_cast<double>(i);
        median.points.emplace_back(x, static_cast<double>(latency.valueAt(50)));
        high.points.emplace_back(x, static_cast<double>(latency.valueAt(99)));
        most.points.emplace_back(x, static_cast<double>(latency.max()));
    }
    const std::size_t step = std::max<std::size_t>(1, result.seconds.size() / 10);
    for (std::size_t i = 0; i < result.seconds.size(); i += step)
        panel.marks.emplace_back(static_cast<double>(i), std::to_string(i) + " s");
    panel.lines = {std::move(most), std::move(high), std::move(median)};
    return panel;
}

}  // namespace

std::string drawSvg(const std::vector<PlotPanel>& panels) {
    const double height = kPanel * static_cast<double>(panels.size());
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " +
                      numberText(kWidth) + " " + numberText(height) +
                      "\" font-family=\"sans-serif\" font-size=\"12\">\n"
                      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
    for (std::size_t i = 0; i < panels.size(); ++i)
        svg += drawPanel(panels[i], kPanel * static_cast<double>(i));
    return svg + "</svg>\n";
}

std::string drawLatency(const LoadResult& result) {
    PlotPanel panel{"latency by percentile", {}, {}};
    panel.lines.push_back({"as sent", "#7f7f7f", spectrum(result.tally[Measure::asSent])});
    panel.lines.push_back({"corrected", "#1f77b4", spectrum(result.tally[Measure::corrected])});
    for (const double percent : {0.0, 50.0, 90.0, 99.0, 99.9, 99.99, 99.999, 99.9999})
        panel.marks.emplace_back(-std::log10(1 - percent / 100), numberText(percent, 4) + " %");
    return drawSvg({panel, timeline(result)});
}

}  // namespace rivage::client::load
