#include "client/load/verdict.h"

#include <algorithm>

namespace rivage::client::load {
namespace {

bool isTime(const std::string& metric) { return metric == "max" || readPercentile(metric); }

std::optional<double> actualOf(const std::string& metric, const LoadResult& result) {
    const Tally& tally = result.tally;
    const Histogram& latency = tally[Measure::corrected];
    if (metric == "goodput") return result.goodput();
    const auto judged = static_cast<double>(tally.judged());
    if (metric != "max" && !readPercentile(metric) && judged == 0) return std::nullopt;
    if (metric == "errors") return tally.errorRate();
    if (metric == "refused") return static_cast<double>(tally.refused) / judged;
    if (metric == "not_sent") return static_cast<double>(tally.notSent()) / judged;
    if (latency.count() == 0) return std::nullopt;
    if (metric == "max") return static_cast<double>(latency.max());
    const auto value = latency.percentile(readPercentile(metric).value_or(50));
    return value ? std::optional(static_cast<double>(*value)) : std::nullopt;
}

std::string valueText(const std::string& metric, double value) {
    if (isTime(metric)) return timeText(static_cast<std::int64_t>(value));
    return metric == "goodput" ? numberText(value) + "/s" : numberText(100 * value, 3) + " %";
}

/// Not one head of an answer has come, though there were connections to send on.
bool nobodyAnswered(const Tally& tally) {
    return tally.failed > 0 && tally.failed == tally.planned && tally.statuses.empty() &&
           tally.notSent() < tally.planned;
}

}  // namespace

LoadExit exitOf(const Failure& failure) {
    switch (failure.exit) {
        case ExitCode::ok: return LoadExit::ok;
        case ExitCode::usage:
        case ExitCode::refused:
        case ExitCode::failed: return LoadExit::usage;
        case ExitCode::unreachable:
        case ExitCode::busy: return LoadExit::unreachable;
        case ExitCode::cancelled: return LoadExit::cancelled;
        case ExitCode::notWritten: return LoadExit::notWritten;
    }
    return LoadExit::usage;
}

std::vector<Judgement> judge(const std::vector<Threshold>& thresholds,
                             const std::optional<Slo>& slo, const LoadResult& result) {
    std::vector<Threshold> all = thresholds;
    if (slo) all.push_back({percentileName(slo->percent), static_cast<double>(slo->limit)});
    std::vector<Judgement> judgements;
    for (Threshold& threshold : all) {
        Judgement one{std::move(threshold), {}, false};
        one.actual = actualOf(one.threshold.metric, result);
        if (one.actual)
            one.kept = one.threshold.metric == "goodput" ? *one.actual >= one.threshold.limit
                                                         : *one.actual <= one.threshold.limit;
        judgements.push_back(std::move(one));
    }
    return judgements;
}

std::string describe(const Judgement& judgement) {
    const auto& [metric, limit] = judgement.threshold;
    return metric + " = " +
           (judgement.actual ? valueText(metric, *judgement.actual) : "n/a (too few samples)") +
           (metric == "goodput" ? ", at least " : ", at most ") + valueText(metric, limit);
}

std::string whatIsMissing(const LoadResult& result) {
    const Tally& tally = result.tally;
    if (result.interrupted || !result.health.valid) return {};
    if (tally.planned == 0) return "nothing was sent in the time that counts, after the warm-up";
    if (nobodyAnswered(tally)) return "no server answered";
    return tally.judged() > 0 && tally.good == 0 ? "no answer was good" : "";
}

LoadExit exitOf(const LoadResult& result, const std::vector<Judgement>& judgements) {
    if (result.interrupted) return LoadExit::cancelled;
    if (!result.health.valid) return LoadExit::late;
    const Tally& tally = result.tally;
    if (nobodyAnswered(tally)) return LoadExit::unreachable;
    if (!whatIsMissing(result).empty()) return LoadExit::missed;
    const bool kept = std::all_of(judgements.begin(), judgements.end(),
                                  [](const Judgement& one) { return one.kept; });
    return kept ? LoadExit::ok : LoadExit::missed;
}

}  // namespace rivage::client::load
