#include "tests/study/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace rivage::study {
namespace {

constexpr double kWidth = 430;  // of a panel
constexpr double kHeight = 300;
constexpr double kLeft = 62;
constexpr double kRight = 14;
constexpr double kTop = 34;
constexpr double kBottom = 48;
constexpr double kLegendRow = 22;
constexpr double kLegendItem = 186;

/// How a series is drawn. The colours are told apart by colour-blind readers (Okabe and Ito).
struct Style {
    const char* name;
    const char* colour;
    const char* dash;
    double width;
};
constexpr std::array<Style, 20> kStyles = {{{"raw", "#999999", "2 3", 1.5},
                                            {"MC", "#e69f00", "", 1.8},
                                            {"DC", "#d55e00", "", 1.8},
                                            {"DC in cell", "#d55e00", "5 4", 1.8},
                                            {"SN", "#56b4e9", "5 4", 1.8},
                                            {"SN 16", "#0072b2", "", 1.8},
                                            {"paper", "#cc79a7", "", 2.2},
                                            {"paper, auto normals", "#cc79a7", "7 4", 2.2},
                                            {"paper, growing II", "#cc79a7", "2 3", 2.2},
                                            {"studio", "#009e73", "", 3},
                                            {"studio, no limit", "#009e73", "2 3", 1.8},
                                            {"studio, growing II", "#009e73", "7 4", 2.2},
                                            {"organic", "#7a5c2e", "7 4", 1.8},
                                            {"architectural", "#444444", "5 2", 1.8},
                                            {"noisy", "#000000", "2 3", 2.2},
                                            {"guided", "#f0c000", "", 2.2},
                                            {"AT", "#8855cc", "", 2.2},
                                            {"II", "#7f0000", "5 4", 2.2},
                                            {"gradient descent", "#d55e00", "", 2.2},
                                            {"accelerated", "#009e73", "", 2.2}}};

const Style& styleOf(const std::string& name) {
    for (const Style& style : kStyles)
        if (name == style.name) return style;
    return kStyles.front();
}

std::string text(double value, int digits = 1) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
    return buffer;
}

std::string markText(double value) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.4g", value);
    return buffer;
}

std::string escaped(const std::string& words) {
    std::string result;
    for (const char c : words)
        result += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    return result;
}

std::string words(double x, double y, const char* anchor, const std::string& what,
                  const char* more = "") {
    return "<text x=\"" + text(x) + "\" y=\"" + text(y) + "\" text-anchor=\"" + anchor + "\"" +
           more + ">" + escaped(what) + "</text>\n";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
    return "<line x1=\"" + text(x1) + "\" y1=\"" + text(y1) + "\" x2=\"" + text(x2) + "\" y2=\"" +
           text(y2) + "\" " + style + "/>\n";
}

/// Hollow where the line is broken, so that dots alone can be told apart.
std::string dot(double x, double y, double radius, const Style& style) {
    const bool hollow = style.dash[0] != '\0';
    return "<circle cx=\"" + text(x) + "\" cy=\"" + text(y) + "\" r=\"" + text(radius) +
           "\" fill=\"" + (hollow ? "#fff" : style.colour) + "\" stroke=\"" + style.colour +
           "\" stroke-width=\"1.4\"/>\n";
}

/// One axis: from values to 0 .. 1.
class Axis {
public:
    explicit Axis(bool logarithmic) : log_(logarithmic) {}
    [[nodiscard]] bool shows(double value) const {
        return std::isfinite(value) && (!log_ || value > 0);
    }
    void add(double value) {
        if (!shows(value)) return;
        low_ = std::min(low_, scaled(value));
        high_ = std::max(high_, scaled(value));
    }
    /// Ends on round values; a plain axis begins at 0.
    void round() {
        if (low_ > high_) low_ = high_ = 0;
        if (log_) {
            low_ -= 0.04 + 0.02 * (high_ - low_);
            high_ += 0.04 + 0.02 * (high_ - low_);
            return;
        }
        low_ = std::min(low_, 0.0);
        high_ = std::max(high_, low_ + 1e-9);
        step_ = std::pow(10, std::floor(std::log10(high_ - low_)));
        for (const double smaller : {0.5, 0.4, 0.5})
            if ((high_ - low_) / step_ < 4) step_ *= smaller;
        high_ = std::ceil(high_ / step_ - 1e-9) * step_;
    }
    /// Both ends at least this far apart on a logarithmic axis.
    void spread(double decades) {
        if (log_ && high_ - low_ < decades) low_ = high_ - decades;
    }
    [[nodiscard]] double at(double value) const {
        return std::clamp((scaled(value) - low_) / (high_ - low_), -0.02, 1.02);
    }
    [[nodiscard]] std::vector<double> marks() const {
        std::vector<double> marks;
        if (!log_) {
            for (double v = std::ceil(low_ / step_) * step_; v <= high_ + 1e-9 * step_; v += step_)
                marks.push_back(std::abs(v) < 1e-9 * step_ ? 0 : v);
            return marks;
        }
        const bool dense = high_ - low_ < 2.2;
        for (double decade = std::floor(low_); decade <= high_; ++decade)
            for (const double digit : {1.0, 2.0, 5.0}) {
                const double v = digit * std::pow(10, decade);
                if ((dense || digit == 1) && std::log10(v) >= low_ && std::log10(v) <= high_)
                    marks.push_back(v);
            }
        return marks;
    }

private:
    [[nodiscard]] double scaled(double value) const { return log_ ? std::log10(value) : value; }
    bool log_;
    double low_ = std::numeric_limits<double>::max();
    double high_ = std::numeric_limits<double>::lowest();
    double step_ = 1;
};

class PanelDrawing {
public:
    PanelDrawing(const PlotPanel& panel, double left, double top, double width)
        : panel_(panel),
          left_(left + kLeft),
          top_(top + kTop),
          innerWidth_(width - kLeft - kRight),
          x_(panel.logX),
          y_(panel.logY) {
        for (const PlotSeries& series : panel.series)
            for (const PlotPoint& point : series.points) {
                if (!y_.shows(point.y)) continue;
                x_.add(point.x);
                y_.add(point.y);
                if (std::isfinite(point.half) && !panel.logY) y_.add(point.y + point.half);
            }
        y_.spread(0.7);
        x_.round();
        y_.round();
    }

    [[nodiscard]] std::string draw() const {
        std::string svg = frame();
        for (const double slope : panel_.slopes) svg += guide(slope);
        for (std::size_t i = 0; i < panel_.series.size(); ++i)
            svg += panel_.categories.empty() ? curve(panel_.series[i], 0)
                                             : curve(panel_.series[i], aside(i));
        return svg;
    }

private:
    static constexpr double kInnerHeight = kHeight - kTop - kBottom;

    [[nodiscard]] double px(double x) const {
        if (panel_.categories.empty()) return left_ + innerWidth_ * x_.at(x);
        return left_ + innerWidth_ * (x - 0.5) / static_cast<double>(panel_.categories.size());
    }
    /// How far from the middle of a category a series stands.
    [[nodiscard]] double aside(std::size_t series) const {
        const auto count = static_cast<double>(panel_.series.size());
        return 0.8 * ((static_cast<double>(series) + 0.5) / count - 0.5);
    }
    [[nodiscard]] double py(double y) const { return top_ + kInnerHeight * (1 - y_.at(y)); }

    /// Marks of the x axis: the places of the points where they are few.
    [[nodiscard]] std::vector<double> xMarks() const {
        std::vector<double> marks;
        for (const PlotSeries& series : panel_.series)
            for (const PlotPoint& point : series.points) marks.push_back(point.x);
        std::sort(marks.begin(), marks.end());
        marks.erase(std::unique(marks.begin(), marks.end()), marks.end());
        return marks.size() <= 6 ? marks : x_.marks();
    }

    [[nodiscard]] std::string frame() const {
        const double bottom = top_ + kInnerHeight;
        const double right = left_ + innerWidth_;
        std::string svg = words(left_, top_ - 12, "start", panel_.title, " font-weight=\"bold\"");
        for (const double y : y_.marks()) {
            svg += line(left_, py(y), right, py(y), "stroke=\"#e3e3e3\"");
            svg += words(left_ - 6, py(y) + 4, "end", markText(y));
        }
        svg += panel_.categories.empty() ? xScale(bottom) : categoryScale(bottom);
        svg += line(left_, bottom, right, bottom, "stroke=\"#333\"");
        svg += line(left_, top_, left_, bottom, "stroke=\"#333\"");
        svg += words(0.5 * (left_ + right), bottom + 36, "middle", panel_.xLabel);
        const std::string turn = " transform=\"rotate(-90 " + text(left_ - 46) + " " +
                                 text(top_ + 0.5 * kInnerHeight) + ")\"";
        svg += words(left_ - 46, top_ + 0.5 * kInnerHeight, "middle", panel_.yLabel, turn.c_str());
        return svg;
    }

    [[nodiscard]] std::string xScale(double bottom) const {
        std::string svg;
        for (const double x : xMarks()) {
            svg += line(px(x), bottom, px(x), bottom + 4, "stroke=\"#333\"");
            svg += words(px(x), bottom + 17, "middle", markText(x));
        }
        return svg;
    }

    [[nodiscard]] std::string categoryScale(double bottom) const {
        std::string svg;
        for (std::size_t i = 0; i < panel_.categories.size(); ++i) {
            const auto x = static_cast<double>(i + 1);
            svg += line(px(x + 0.5), top_, px(x + 0.5), bottom, "stroke=\"#e3e3e3\"");
            // In two rows, so that neighbours have room.
            svg += words(px(x), bottom + (i % 2 == 0 ? 17 : 32), "middle", panel_.categories[i]);
        }
        return svg;
    }

    [[nodiscard]] std::string guide(double slope) const {
        const auto named =
            std::find_if(panel_.series.begin(), panel_.series.end(),
                         [](const PlotSeries& series) { return series.name == "studio"; });
        if (named == panel_.series.end() || named->points.size() < 2) return {};
        const auto& points = named->points;
        const auto [a, b] =
            std::minmax_element(points.begin(), points.end(),
                                [](const PlotPoint& p, const PlotPoint& q) { return p.x < q.x; });
        const double end = b->y * std::pow(b->x / a->x, slope);
        return line(px(b->x), py(b->y), px(a->x), py(end),
                    "stroke=\"#bbb\" stroke-dasharray=\"1 3\"") +
               words(px(a->x) + 4, py(end) + 14, "start", "order " + markText(slope),
                     " fill=\"#888\"");
    }

    /// @param moved  along x, for points side by side: they are not joined then
    [[nodiscard]] std::string curve(const PlotSeries& series, double moved) const {
        const Style& style = styleOf(series.name);
        const std::string stroke = std::string("stroke=\"") + style.colour + "\"";
        const bool joined = panel_.categories.empty();
        std::string bars;
        std::string dots;
        std::string path;
        for (const PlotPoint& p : series.points) {
            if (!y_.shows(p.y) || !x_.shows(p.x)) continue;
            const double x = px(p.x + moved);
            path += text(x) + "," + text(py(p.y)) + " ";
            dots += dot(x, py(p.y), joined ? 2.6 : 3.4, style);
            if (std::isfinite(p.half) && p.half > 0 && y_.shows(p.y - p.half))
                bars += line(x, py(p.y - p.half), x, py(p.y + p.half), stroke);
        }
        if (!joined) return bars + dots;
        return bars + "<polyline fill=\"none\" " + stroke + " stroke-width=\"" + text(style.width) +
               "\" stroke-dasharray=\"" + style.dash + "\" points=\"" + path + "\"/>\n" + dots;
    }

    const PlotPanel& panel_;
    double left_;
    double top_;
    double innerWidth_;
    Axis x_;
    Axis y_;
};

std::vector<std::string> namesOf(const std::vector<PlotPanel>& panels) {
    std::vector<std::string> names;
    for (const PlotPanel& panel : panels)
        for (const PlotSeries& series : panel.series)
            if (!series.points.empty() &&
                std::find(names.begin(), names.end(), series.name) == names.end())
                names.push_back(series.name);
    return names;
}

std::string legend(const std::vector<std::string>& names, int perRow) {
    std::string svg;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const Style& style = styleOf(names[i]);
        const std::size_t row = i / perRow;
        const double x = 16 + kLegendItem * static_cast<double>(i % perRow);
        const double y = 20 + kLegendRow * static_cast<double>(row);
        svg += line(x, y - 4, x + 30, y - 4,
                    std::string("stroke=\"") + style.colour + "\" stroke-width=\"" +
                        text(style.width) + "\" stroke-dasharray=\"" + style.dash + "\"");
        svg += dot(x + 15, y - 4, 3, style);
        svg += words(x + 36, y, "start", names[i]);
    }
    return svg;
}

}  // namespace

std::string drawPlot(const std::vector<PlotPanel>& panels, int columns) {
    const double panelWidth = columns == 1 ? 2 * kWidth : kWidth;
    const double width = panelWidth * columns;
    const std::vector<std::string> names = namesOf(panels);
    const int perRow = std::max(1, static_cast<int>((width - 16) / kLegendItem));
    const std::size_t legendRows = (names.size() + perRow - 1) / perRow;
    const double head = 12 + kLegendRow * static_cast<double>(legendRows);
    const std::size_t rows = (panels.size() + columns - 1) / columns;
    std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + text(width, 0) +
                      " " + text(head + kHeight * static_cast<double>(rows), 0) +
                      "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#222\">\n"
                      "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";
    svg += legend(names, perRow);
    for (std::size_t i = 0; i < panels.size(); ++i) {
        const std::size_t row = i / columns;
        const double left = panelWidth * static_cast<double>(i % columns);
        const double top = head + kHeight * static_cast<double>(row);
        svg += PanelDrawing(panels[i], left, top, panelWidth).draw();
    }
    return svg + "</svg>\n";
}

}  // namespace rivage::study
