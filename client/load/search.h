#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/load/verdict.h"

namespace rivage::client::load {

/// How the knee is looked for.
struct SearchPlan {
    LoadPlan load;  ///< its arrivals and its duration are set anew for each rate
    Slo slo{99, 500'000};
    double maxErrors = 0.001;  ///< share of the answers, refusals included
    double from = 0;           ///< the first rate; 0: a quarter of what a closed loop reaches
    double to = 1e6;
    double precision = 0.05;  ///< of the knee, relative
    double window = 5;        ///< s
    int windows = 10;         ///< at most, for a rate
    bool poisson = false;
    std::vector<double> curve{0.5, 1, 2, 3};  ///< multiples of the knee that are measured at last
};

/// What one rate came to.
struct RatePoint {
    double rate = 0;
    bool stable = false;  ///< three windows in a row agree within 10 %
    bool kept = false;    ///< the limit of the latency and that of the errors
    int windows = 0;
    LoadResult result;   ///< of the whole time at this rate
    Histogram latency;   ///< of the windows that count
    double answers = 0;  ///< good ones a second, however late
    double goodput = 0;  ///< those of them within the limit
    double errorRate = 0;
};

struct SearchResult {
    double capacity = 0;  ///< good answers a second of the closed loop before the search
    double knee = 0;      ///< 0: not even the lowest rate was kept
    std::vector<RatePoint> steps;
    std::vector<RatePoint> curve;
    bool valid = true;   ///< the generator kept up at the knee, or at the lowest rate
    std::string reason;  ///< why not
    bool interrupted = false;
};

/// Measures one rate until three windows in a row agree, or until it is clear that it is too much.
using MeasureRate = std::function<RatePoint(double rate)>;

/// Doubles the rate until one is not kept, then halves the interval; the knee is the highest rate
/// that was kept.
/// @param stop  whether to give up
SearchResult findKnee(const SearchPlan& plan, const MeasureRate& measure,
                      const std::function<bool()>& stop);

/// The whole search: a closed loop for a first guess, the knee, the curve around it.
/// @param say  one line for each rate that was measured
SearchResult runSearch(const SearchPlan& plan, Interrupt& interrupt,
                       const std::function<void(const std::string&)>& say);

/// Whether the goodput and the median of three windows are each within 10 % of their mean.
[[nodiscard]] bool windowsAgree(const std::vector<Second>& windows);

/// The table of the curve, as Markdown.
[[nodiscard]] std::string curveMarkdown(const SearchPlan& plan, const SearchResult& result);
[[nodiscard]] proto::Json searchJson(const SearchPlan& plan, const SearchResult& result);
[[nodiscard]] LoadExit exitOf(const SearchResult& result);

}  // namespace rivage::client::load
