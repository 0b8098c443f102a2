#include "tests/study/statistics.h"

#include <array>
#include <cmath>
#include <limits>

namespace rivage::study {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

}  // namespace

double studentQuantile(std::size_t degreesOfFreedom) {
    static constexpr std::array<double, 30> table = {
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
        2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
        2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042};
    if (degreesOfFreedom == 0) return kNone;
    if (degreesOfFreedom <= table.size()) return table[degreesOfFreedom - 1];
    // The first terms of its expansion about the normal distribution; off by less than 0.001.
    const double z = 1.959964;
    const auto n = static_cast<double>(degreesOfFreedom);
    return z + (z * z * z + z) / (4 * n) +
           (5 * std::pow(z, 5) + 16 * z * z * z + 3 * z) / (96 * n * n);
}

Interval meanOf(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    const auto n = static_cast<double>(values.size());
    const double mean = sum / n;
    double squares = 0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    if (values.size() < 2) return {values.empty() ? kNone : mean, kNone};
    return {mean, studentQuantile(values.size() - 1) * std::sqrt(squares / (n - 1) / n)};
}

Ratio ratioOf(const std::vector<std::pair<double, double>>& pairs) {
    std::vector<double> logs;
    for (const auto& [ours, theirs] : pairs)
        if (ours > 0 && theirs > 0) logs.push_back(std::log(ours / theirs));
    const Interval log = meanOf(logs);
    return {std::exp(log.mean), std::exp(log.low()), std::exp(log.high())};
}

Interval orderOf(const std::vector<std::pair<double, double>>& points) {
    double n = 0;
    double meanX = 0;
    double meanY = 0;
    for (const auto& [x, y] : points) {
        ++n;
        meanX += std::log(x);
        meanY += std::log(y);
    }
    meanX /= n;
    meanY /= n;
    double xx = 0;
    double xy = 0;
    double yy = 0;
    for (const auto& [x, y] : points) {
        const double dx = std::log(x) - meanX;
        const double dy = std::log(y) - meanY;
        xx += dx * dx;
        xy += dx * dy;
        yy += dy * dy;
    }
    if (points.size() < 3 || xx == 0) return {xx == 0 ? kNone : xy / xx, kNone};
    const double slope = xy / xx;
    const double rest = std::max(yy - slope * xy, 0.0) / (n - 2);
    return {slope, studentQuantile(points.size() - 2) * std::sqrt(rest / xx)};
}

}  // namespace rivage::study
