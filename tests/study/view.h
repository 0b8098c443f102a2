#pragma once

#include <string>
#include <vector>

#include "tests/study/plot.h"
#include "tests/study/samples.h"
#include "tests/study/statistics.h"

namespace rivage::study {

/// Questions to the samples of a section. Intervals are over the poses.
class View {
public:
    explicit View(const Samples& samples) : samples_(samples) {}

    [[nodiscard]] std::vector<std::string> shapes() const;
    [[nodiscard]] std::vector<std::string> methods() const;
    [[nodiscard]] std::vector<double> levels() const;    ///< ascending
    [[nodiscard]] std::vector<int> resolutions() const;  ///< ascending

    /// Which samples are meant.
    struct Query {
        std::string shape = {};  ///< empty: the mean over all shapes, pose by pose
        std::string method;
        double level = 0;
        Measure measure = Measure::rms;
        int resolution = 0;  ///< 0: any
    };
    [[nodiscard]] std::vector<double> values(const Query& query) const;
    [[nodiscard]] Interval mean(const Query& query) const { return meanOf(values(query)); }
    /// Sum, or greatest, of all matching samples; 0 without any.
    [[nodiscard]] double sum(const Query& query) const;
    [[nodiscard]] double greatest(const Query& query) const;

    /// The measure of `query.method` over that of `other`; of all shapes: the geometric mean over
    /// the shapes of each pose.
    [[nodiscard]] Ratio ratio(const Query& query, const std::string& other) const;
    /// Shapes where `query.method` has the larger measure, by the interval of its ratio.
    [[nodiscard]] std::vector<std::string> worseShapes(const Query& query,
                                                       const std::string& other) const;

    /// A line over the levels, or over the resolutions, for `query.shape` (or the mean of all).
    [[nodiscard]] PlotSeries overLevels(Query query) const;
    [[nodiscard]] PlotSeries overResolutions(Query query, double exponent) const;

    /// Milliseconds, the mean over all samples of a method at a resolution.
    [[nodiscard]] Interval time(const std::string& method, int resolution) const;

    [[nodiscard]] const Samples& samples() const { return samples_; }

private:
    [[nodiscard]] static bool matches(const Sample& sample, const Query& query);
    [[nodiscard]] std::vector<std::pair<double, double>> pairs(const Query& query,
                                                               const std::string& other) const;

    const Samples& samples_;
};

}  // namespace rivage::study
