// The forms of a report that programs read.
#include <set>

#include "client/load/report.h"

namespace rivage::client::load {
namespace {

using proto::Json;

Json optionalTime(std::optional<std::int64_t> value) { return value ? Json(*value) : Json(); }

Json summary(const Histogram& histogram) {
    Json json{{"count", histogram.count()}};
    for (const double percent : toldPercentiles())
        json[percentileName(percent)] = optionalTime(histogram.percentile(percent));
    json["max"] = histogram.count() == 0 ? Json() : Json(histogram.max());
    json["mean"] = histogram.count() == 0 ? Json() : Json(histogram.mean());
    return json;
}

Json planJson(const LoadPlan& plan) {
    Json json{{"server", toText(plan.target.endpoint)},
              {"mode", nameOf(plan.arrivals.kind)},
              {"rate", plan.arrivals.rate},
              {"concurrency",
               plan.arrivals.kind == Arrivals::closed ? Json(plan.arrivals.concurrency) : Json()},
              {"warmup_s", plan.warmup.count()},
              {"duration_s", plan.duration.count()},
              {"threads", plan.threads},
              {"pins", plan.pins},
              {"seed", plan.seed},
              {"verify", plan.verify},
              {"slo_us", plan.sloLimit < Histogram::kHighest ? Json(plan.sloLimit) : Json()},
              {"keep_alive", plan.limits.keepAlive},
              {"timeout_ms", plan.limits.timeout.count()}};
    const Mix& mix = plan.mix.mix;
    json["mix"] = {
        {"duplicates", mix.duplicates}, {"aborts", mix.aborts}, {"slow_clients", mix.slowClients}};
    return json;
}

Json countsJson(const LoadResult& result) {
    const Tally& tally = result.tally;
    return {{"planned", tally.planned},     {"sent", tally.sent},
            {"good", tally.good},           {"within_slo", tally.withinSlo},
            {"refused", tally.refused},     {"failed", tally.failed},
            {"aborted", tally.aborted},     {"abandoned", tally.abandoned},
            {"cancelled", tally.cancelled}, {"slow_clients", tally.slow},
            {"late", tally.late},           {"not_sent", tally.notSent()},
            {"retried", tally.retried},     {"jobs", tally.jobs},
            {"polls", tally.polls},         {"connections", result.connections},
            {"bytes_in", result.bytesIn},   {"bytes_out", result.bytesOut},
            {"verified", result.verified},  {"verification_skipped", result.unverified}};
}

Json entriesJson(const LoadReport& report) {
    Json entries = Json::array();
    const auto names = report.plan.mix.mix.names();
    for (std::size_t i = 0; i < names.size(); ++i) {
        const EntryTally& entry = report.result.tally.entries[i];
        entries.push_back({{"name", names[i]},
                           {"planned", entry.planned},
                           {"good", entry.good},
                           {"corrected", summary(entry.corrected)}});
    }
    return entries;
}

Json judgementsJson(const LoadReport& report) {
    Json list = Json::array();
    for (const Judgement& one : report.judgements)
        list.push_back({{"metric", one.threshold.metric},
                        {"limit", one.threshold.limit},
                        {"actual", one.actual ? Json(*one.actual) : Json()},
                        {"kept", one.kept}});
    return list;
}

}  // namespace

Json reportJson(const LoadReport& report) {
    const LoadResult& result = report.result;
    Json latency = Json::object();
    Json histograms = Json::object();
    for (const Measure measure : allMeasures()) {
        const Histogram& histogram = result.tally[measure];
        if (histogram.count() == 0) continue;
        latency[nameOf(measure)] = summary(histogram);
        histograms[nameOf(measure)] = histogram.toJson();
    }
    Json statuses = Json::object();
    for (const auto& [status, count] : result.tally.statuses)
        statuses[std::to_string(status)] = count;
    Json metrics = Json::array();
    for (const MetricsSample& sample : result.metrics) metrics.push_back(sample);
    const GeneratorHealth& health = result.health;
    return {{"plan", planJson(report.plan)},
            {"environment", report.environment},
            {"server", report.server},
            {"measured_s", result.duration},
            {"offered_per_s", result.offered()},
            {"goodput_per_s", result.goodput()},
            {"error_rate", result.tally.judged() == 0 ? Json() : Json(result.tally.errorRate())},
            {"requests", countsJson(result)},
            {"errors", result.tally.errors},
            {"statuses", std::move(statuses)},
            {"latency_us", std::move(latency)},
            {"entries", entriesJson(report)},
            {"thresholds", judgementsJson(report)},
            {"generator",
             {{"valid", health.valid},
              {"reason", health.reason},
              {"late_share", health.lateShare},
              {"cpu", health.cpu},
              {"load_average", health.loadAverage},
              {"not_sent", health.notSent}}},
            {"exit_code", static_cast<int>(exitOf(result, report.judgements))},
            {"server_metrics", std::move(metrics)},
            {"histograms", std::move(histograms)}};
}

std::string reportCsv(const LoadReport& report) {
    std::set<std::string> names;
    for (const MetricsSample& sample : report.result.metrics)
        for (const auto& [name, value] : sample) names.insert(name);
    std::string text = "second,ended,good,within_slo,refused,failed,bytes_in,p50_us,p99_us,max_us";
    for (const std::string& name : names) text += "," + name;
    text += "\n";
    // What the server says is asked for from the beginning of the warm-up.
    const auto shift = static_cast<std::size_t>(report.plan.warmup.count());
    const auto cell = [](std::optional<std::int64_t> value) {
        return value ? std::to_string(*value) : std::string();
    };
    for (std::size_t i = 0; i < report.result.seconds.size(); ++i) {
        const Second& second = report.result.seconds[i];
        const Histogram latency = second.latency();
        text += std::to_string(i);
        for (const std::uint64_t value : {second.sent, second.good, second.withinSlo,
                                          second.refused, second.failed, second.bytesIn})
            text += "," + std::to_string(value);
        text += "," + cell(latency.percentile(50)) + "," + cell(latency.percentile(99)) + "," +
                (latency.count() == 0 ? "" : std::to_string(latency.max()));
        for (const std::string& name : names) {
            text += ",";
            if (i + shift >= report.result.metrics.size()) continue;
            const MetricsSample& sample = report.result.metrics[i + shift];
            if (const auto found = sample.find(name); found != sample.end())
                text += numberText(found->second, 6);
        }
        text += "\n";
    }
    return text;
}

}  // namespace rivage::client::load
