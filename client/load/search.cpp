#include "client/load/search.h"

#include <algorithm>
#include <cmath>

#include "client/load/report.h"

namespace rivage::client::load {
namespace {

constexpr double kAgreement = 0.1;
constexpr std::size_t kAgreeing = 3;   // windows in a row
constexpr std::size_t kLateSteps = 3;  // in a row: the generator will not do better
/// The closed loop before a search: long enough to start threads and to fill caches.
constexpr double kProbeSeconds = 3;
constexpr int kProbeClients = 4;

bool within(const std::vector<double>& values) {
    double mean = 0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    return std::all_of(values.begin(), values.end(), [&](double value) {
        return std::abs(value - mean) <= kAgreement * mean + 1e-9;
    });
}

/// The windows of the seconds that are over.
std::vector<Second> windowsOf(const Series& series, std::size_t window) {
    std::vector<Second> windows;
    for (std::size_t end = window; end + 1 <= series.size(); end += window)
        windows.push_back(series.between(end - window, end));
    return windows;
}

double errorRate(const Second& sum) {
    const auto all = static_cast<double>(sum.good + sum.refused + sum.failed);
    return all == 0 ? 1 : static_cast<double>(sum.refused + sum.failed) / all;
}

bool keeps(const SearchPlan& plan, const Second& sum) {
    return sum.good > 0 && errorRate(sum) <= plan.maxErrors &&
           sum.latency().valueAt(plan.slo.percent) <= plan.slo.limit;
}

/// More of the same would not change the answer: it is stable, or two windows are far too slow.
bool decided(const SearchPlan& plan, const std::vector<Second>& windows) {
    const auto missed = std::count_if(windows.begin(), windows.end(),
                                      [&](const Second& one) { return !keeps(plan, one); });
    return windowsAgree(windows) || missed >= 2;
}

/// @param count  so many of the last windows count
void judgeWindows(const SearchPlan& plan, const std::vector<Second>& windows, std::size_t count,
                  RatePoint& point) {
    count = std::min(count, windows.size());
    Second sum;
    for (std::size_t i = windows.size() - count; i < windows.size(); ++i) sum.merge(windows[i]);
    point.windows = static_cast<int>(windows.size());
    point.stable = windowsAgree(windows);
    point.latency = sum.latency();
    point.errorRate = errorRate(sum);
    const double seconds = plan.window * static_cast<double>(count);
    point.answers = seconds > 0 ? static_cast<double>(sum.good) / seconds : 0;
    point.goodput = seconds > 0 ? static_cast<double>(sum.withinSlo) / seconds : 0;
    point.kept = count > 0 && keeps(plan, sum);
}

/// @param whole  all windows are measured and count, so that there are samples for high percentiles;
///               else it ends when it is decided, by the last three
RatePoint measureRate(const SearchPlan& plan, double rate, Interrupt& interrupt, bool whole) {
    LoadPlan load = plan.load;
    load.arrivals.kind = plan.poisson ? Arrivals::poisson : Arrivals::constant;
    load.arrivals.rate = rate;
    load.sloLimit = plan.slo.limit;
    load.duration = std::chrono::duration<double>(plan.window * plan.windows + 1);
    const auto window = static_cast<std::size_t>(std::max(1.0, plan.window));
    std::vector<Second> windows;
    RatePoint point{.rate = rate};
    point.result = runLoad(load, interrupt, [&](const Series& series) {
        windows = windowsOf(series, window);
        const auto count = static_cast<int>(windows.size());
        return count < plan.windows && (whole || !decided(plan, windows));
    });
    judgeWindows(plan, windows, whole ? windows.size() : kAgreeing, point);
    return point;
}

/// What the judgement went by, however few the samples; nothing if there are none.
std::optional<std::int64_t> measuredAt(const Histogram& histogram, double percent) {
    return histogram.count() == 0 ? std::nullopt : std::optional(histogram.valueAt(percent));
}

std::string describePoint(const SearchPlan& plan, const RatePoint& point) {
    const std::string name = percentileName(plan.slo.percent);
    const auto told = [&](double percent) { return timeText(measuredAt(point.latency, percent)); };
    std::string text = numberText(point.rate, 2) + "/s: answers " + numberText(point.answers, 2) +
                       "/s, in time " + numberText(point.goodput, 2) + "/s, p50 " + told(50) +
                       ", " + name + " " + told(plan.slo.percent) + ", errors " +
                       numberText(100 * point.errorRate, 2) + " %, " +
                       std::to_string(point.windows) + " windows" +
                       (point.stable ? "" : ", not stable") + (point.kept ? "" : ": too much");
    if (!point.result.health.valid) text += "\n  not valid: " + point.result.health.reason;
    return text;
}

double probeCapacity(const SearchPlan& plan, Interrupt& interrupt) {
    LoadPlan load = plan.load;
    load.arrivals = {.kind = Arrivals::closed, .concurrency = kProbeClients};
    load.duration = std::chrono::duration<double>(kProbeSeconds);
    const LoadResult result = runLoad(load, interrupt);
    return result.duration <= 0 ? 0 : static_cast<double>(result.tally.good) / result.duration;
}

/// The offered rates of the curve that the load in a report of the curve can have.
std::vector<std::string> curveRow(double factor, const SearchPlan& plan, const RatePoint& point) {
    const Histogram& refused = point.result.tally[Measure::refused];
    const Histogram& lag = point.result.tally[Measure::lag];
    const double refusals = point.result.duration <= 0
                                ? 0
                                : static_cast<double>(refused.count()) / point.result.duration;
    return {numberText(factor, 2) + "x",
            numberText(point.rate, 2),
            numberText(point.answers, 2),
            numberText(point.goodput, 2),
            timeText(point.latency.percentile(50)),
            timeText(point.latency.percentile(plan.slo.percent)),
            std::to_string(point.latency.count()),
            numberText(refusals, 2),
            timeText(refused.percentile(99)),
            !point.result.health.valid ? "not valid" : timeText(measuredAt(lag, 99))};
}

proto::Json timeJson(std::optional<std::int64_t> time) {
    return time ? proto::Json(*time) : proto::Json();
}

/// A result is as good as the generator was at one rate.
void judgeBy(const RatePoint& point, SearchResult& result) {
    result.valid = point.result.health.valid;
    result.reason = point.result.health.reason;
}

}  // namespace

bool windowsAgree(const std::vector<Second>& windows) {
    if (windows.size() < kAgreeing) return false;
    std::vector<double> rates;
    std::vector<double> medians;
    for (std::size_t i = windows.size() - kAgreeing; i < windows.size(); ++i) {
        rates.push_back(static_cast<double>(windows[i].good));
        medians.push_back(static_cast<double>(windows[i].latency().valueAt(50)));
    }
    return within(rates) && within(medians);
}

SearchResult findKnee(const SearchPlan& plan, const MeasureRate& measure,
                      const std::function<bool()>& stop) {
    SearchResult result;
    const auto tryRate = [&](double rate) {
        result.steps.push_back(measure(rate));
        if (!result.steps.back().kept) return false;
        result.knee = std::max(result.knee, rate);
        judgeBy(result.steps.back(), result);
        return true;
    };
    double low = 0;
    double high = 0;
    // What a generator says that is always late is worth nothing, and each step takes its time.
    const auto over = [&] {
        const auto late = [](const RatePoint& point) { return !point.result.health.valid; };
        return stop() ||
               (result.steps.size() >= kLateSteps &&
                std::all_of(result.steps.rbegin(), result.steps.rbegin() + kLateSteps, late));
    };
    for (double rate = plan.from; !over() && high == 0 && rate <= plan.to; rate *= 2)
        (tryRate(rate) ? low : high) = rate;
    // The first rate was too much already: down, until one is kept.
    for (double rate = plan.from / 2; !over() && low == 0 && rate >= plan.from / 64; rate /= 2)
        (tryRate(rate) ? low : high) = rate;
    while (!over() && low > 0 && high > 0 && high - low > plan.precision * low) {
        const double middle = (low + high) / 2;
        (tryRate(middle) ? low : high) = middle;
    }
    if (result.knee <= 0 && !result.steps.empty()) judgeBy(result.steps.back(), result);
    // What kept a rate from being kept was perhaps not the server.
    for (const RatePoint& step : result.steps)
        if (step.result.health.shortage.count > 0) judgeBy(step, result);
    return result;
}

SearchResult runSearch(const SearchPlan& plan, Interrupt& interrupt,
                       const std::function<void(const std::string&)>& say) {
    SearchPlan search = plan;
    const double capacity = probeCapacity(plan, interrupt);
    say("closed loop, " + std::to_string(kProbeClients) + " in flight: " + numberText(capacity, 2) +
        "/s");
    if (search.from <= 0) search.from = std::max(capacity / 4, 0.1);
    const auto stop = [&] { return interrupt.requested() || capacity <= 0; };
    const auto measure = [&](double rate, bool whole) {
        RatePoint point = measureRate(search, rate, interrupt, whole);
        say(describePoint(search, point));
        return point;
    };
    SearchResult result = findKnee(
        search, [&](double rate) { return measure(rate, false); }, stop);
    result.capacity = capacity;
    for (const double factor : search.curve) {
        if (stop() || result.knee <= 0 || !result.valid) break;
        result.curve.push_back(measure(factor * result.knee, true));
    }
    result.interrupted = interrupt.requested();
    return result;
}

LoadExit exitOf(const SearchResult& result) {
    if (result.interrupted) return LoadExit::cancelled;
    if (result.capacity <= 0) return LoadExit::unreachable;
    if (!result.valid) return LoadExit::late;
    return result.knee > 0 ? LoadExit::ok : LoadExit::missed;
}

std::string curveMarkdown(const SearchPlan& plan, const SearchResult& result) {
    const std::string name = percentileName(plan.slo.percent);
    std::string text = result.valid ? "" : "not valid: " + result.reason + "\n\n";
    text += "knee: " + numberText(result.knee, 2) + "/s with " + name +
            " <= " + timeText(plan.slo.limit) +
            " and errors <= " + numberText(100 * plan.maxErrors, 3) + " %\n\n";
    text += "| load | offered/s | answers/s | in time/s | p50 | " + name +
            " corrected | samples | refusals/s | p99 of refusals | send lag p99 |\n"
            "|---|---|---|---|---|---|---|---|---|---|\n";
    for (std::size_t i = 0; i < result.curve.size(); ++i) {
        text += "|";
        for (const std::string& cell : curveRow(plan.curve[i], plan, result.curve[i]))
            text += " " + cell + " |";
        text += "\n";
    }
    return text;
}

proto::Json searchJson(const SearchPlan& plan, const SearchResult& result) {
    const auto points = [&](const std::vector<RatePoint>& list) {
        proto::Json json = proto::Json::array();
        for (const RatePoint& point : list)
            json.push_back(
                {{"rate", point.rate},
                 {"kept", point.kept},
                 {"stable", point.stable},
                 {"windows", point.windows},
                 {"answers_per_s", point.answers},
                 {"goodput_per_s", point.goodput},
                 {"error_rate", point.errorRate},
                 {"p50_us", timeJson(measuredAt(point.latency, 50))},
                 {"slo_percentile_us", timeJson(measuredAt(point.latency, plan.slo.percent))},
                 {"errors", point.result.tally.errors},
                 {"generator_valid", point.result.health.valid},
                 {"latency", point.latency.toJson()},
                 {"refused", point.result.tally[Measure::refused].toJson()}});
        return json;
    };
    return {{"slo", {{"percentile", plan.slo.percent}, {"limit_us", plan.slo.limit}}},
            {"max_error_rate", plan.maxErrors},
            {"window_s", plan.window},
            {"closed_loop_per_s", result.capacity},
            {"knee_per_s", result.knee},
            {"valid", result.valid},
            {"reason", result.reason},
            {"exit_code", static_cast<int>(exitOf(result))},
            {"steps", points(result.steps)},
            {"curve", points(result.curve)}};
}

}  // namespace rivage::client::load
