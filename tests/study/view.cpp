#include "tests/study/view.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace rivage::study {
namespace {

/// The distinct values of a field, in the order of their first sample.
template <typename Field>
std::vector<std::string> namesOf(const Samples& samples, Field field) {
    std::vector<std::string> names;
    for (const Sample& sample : samples)
        if (std::find(names.begin(), names.end(), sample.*field) == names.end())
            names.push_back(sample.*field);
    return names;
}

template <typename Value, typename Field>
std::vector<Value> numbersOf(const Samples& samples, Field field) {
    std::set<Value> numbers;
    for (const Sample& sample : samples) numbers.insert(sample.*field);
    return {numbers.begin(), numbers.end()};
}

}  // namespace

std::vector<std::string> View::shapes() const { return namesOf(samples_, &Sample::shape); }
std::vector<std::string> View::methods() const { return namesOf(samples_, &Sample::method); }
std::vector<double> View::levels() const { return numbersOf<double>(samples_, &Sample::level); }
std::vector<int> View::resolutions() const { return numbersOf<int>(samples_, &Sample::resolution); }

bool View::matches(const Sample& sample, const Query& query) {
    return (query.shape.empty() || sample.shape == query.shape) && sample.method == query.method &&
           sample.level == query.level &&
           (query.resolution == 0 || sample.resolution == query.resolution);
}

std::vector<double> View::values(const Query& query) const {
    std::map<int, std::vector<double>> byPose;
    for (const Sample& sample : samples_)
        if (matches(sample, query) && !std::isnan(sample.measures[query.measure]))
            byPose[sample.pose].push_back(sample.measures[query.measure]);
    std::vector<double> values;
    for (const auto& [pose, ofShapes] : byPose) values.push_back(meanOf(ofShapes).mean);
    return values;
}

double View::sum(const Query& query) const {
    double sum = 0;
    for (const Sample& sample : samples_)
        if (matches(sample, query) && !std::isnan(sample.measures[query.measure]))
            sum += sample.measures[query.measure];
    return sum;
}

double View::greatest(const Query& query) const {
    double greatest = 0;
    for (const Sample& sample : samples_)
        if (matches(sample, query)) greatest = std::max(greatest, sample.measures[query.measure]);
    return greatest;
}

std::vector<std::pair<double, double>> View::pairs(const Query& query,
                                                   const std::string& other) const {
    struct Logs {
        double ours = 0;
        double theirs = 0;
        double count = 0;
    };
    Query peer = query;
    peer.method = other;
    std::map<std::pair<int, std::string>, std::pair<double, double>> both;
    for (const Sample& sample : samples_) {
        if (matches(sample, query))
            both[{sample.pose, sample.shape}].first = sample.measures[query.measure];
        if (matches(sample, peer))
            both[{sample.pose, sample.shape}].second = sample.measures[query.measure];
    }
    std::map<int, Logs> byPose;
    for (const auto& [key, values] : both) {
        if (!(values.first > 0) || !(values.second > 0)) continue;
        Logs& logs = byPose[key.first];
        logs.ours += std::log(values.first);
        logs.theirs += std::log(values.second);
        ++logs.count;
    }
    std::vector<std::pair<double, double>> result;
    for (const auto& [pose, logs] : byPose)
        result.emplace_back(std::exp(logs.ours / logs.count), std::exp(logs.theirs / logs.count));
    return result;
}

Ratio View::ratio(const Query& query, const std::string& other) const {
    return ratioOf(pairs(query, other));
}

std::vector<std::string> View::worseShapes(const Query& query, const std::string& other) const {
    std::vector<std::string> worse;
    for (const std::string& shape : shapes()) {
        Query one = query;
        one.shape = shape;
        if (ratio(one, other).more()) worse.push_back(shape);
    }
    return worse;
}

PlotSeries View::overLevels(Query query) const {
    PlotSeries series{query.method, {}};
    for (const double level : levels()) {
        query.level = level;
        const Interval interval = mean(query);
        if (!std::isnan(interval.mean))
            series.points.push_back({level, interval.mean, interval.half});
    }
    return series;
}

PlotSeries View::overResolutions(Query query, double exponent) const {
    PlotSeries series{query.method, {}};
    for (const int resolution : resolutions()) {
        query.resolution = resolution;
        const Interval interval = mean(query);
        const double scale = std::pow(resolution, exponent);
        if (!std::isnan(interval.mean))
            series.points.push_back(
                {static_cast<double>(resolution), scale * interval.mean, scale * interval.half});
    }
    return series;
}

Interval View::time(const std::string& method, int resolution) const {
    std::vector<double> times;
    for (const Sample& sample : samples_)
        if (sample.method == method && sample.resolution == resolution)
            times.push_back(sample.milliseconds);
    return meanOf(times);
}

}  // namespace rivage::study
