#pragma once

#include <utility>
#include <vector>

/// Means with confidence intervals, all at 95 % by Student's t distribution.
namespace rivage::study {

/// A mean and the half width of its interval; NaN without values, and no width for one value.
struct Interval {
    double mean;
    double half;
    [[nodiscard]] double low() const { return mean - half; }
    [[nodiscard]] double high() const { return mean + half; }
};

[[nodiscard]] Interval meanOf(const std::vector<double>& values);

/// The factor between paired values, from the mean of the logarithms of their quotients.
struct Ratio {
    double value;
    double low;
    double high;
    /// The whole interval lies below 1, or above.
    [[nodiscard]] bool less() const { return high < 1; }
    [[nodiscard]] bool more() const { return low > 1; }
};
[[nodiscard]] Ratio ratioOf(const std::vector<std::pair<double, double>>& pairs);

/// The exponent p of y = c x^p by least squares of the logarithms, with its interval.
[[nodiscard]] Interval orderOf(const std::vector<std::pair<double, double>>& points);

/// The 97.5 % quantile of Student's distribution.
[[nodiscard]] double studentQuantile(std::size_t degreesOfFreedom);

}  // namespace rivage::study
