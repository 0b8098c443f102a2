#include "client/load/report.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

#include "client/printable.h"

namespace rivage::client::load {
namespace {

/// A table with a head and columns that are as wide as they need to be.
std::string alignedTable(const std::vector<std::vector<std::string>>& rows) {
    std::vector<std::size_t> widths;
    for (const auto& row : rows) {
        widths.resize(std::max(widths.size(), row.size()));
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
    }
    std::string text;
    for (const auto& row : rows) {
        std::string line;
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::string space(widths[i] - row[i].size(), ' ');
            line += i == 0 ? row[i] + space : "  " + space + row[i];
        }
        text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
    }
    return text;
}

/// Text that stays within its cell, and is text only.
std::string markdownCell(const std::string& text) {
    std::string cell;
    for (const char c : printable(text)) {
        if (std::string_view("\\|`[]").find(c) != std::string_view::npos) cell += '\\';
        cell += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    }
    return cell;
}

std::string markdownTable(const std::vector<std::vector<std::string>>& rows) {
    std::string text;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        text += "|";
        for (const std::string& cell : rows[i]) text += " " + markdownCell(cell) + " |";
        text += "\n";
        if (i > 0) continue;
        text += "|";
        for (std::size_t j = 0; j < rows[i].size(); ++j) text += "---|";
        text += "\n";
    }
    return text;
}

std::vector<std::vector<std::string>> latencyRows(const Tally& tally) {
    std::vector<std::vector<std::string>> rows(1, {"latency"});
    for (const double percent : toldPercentiles()) rows[0].push_back(percentileName(percent));
    rows[0].insert(rows[0].end(), {"max", "samples"});
    for (const auto& [name, measure] :
         {std::pair{"corrected", Measure::corrected}, std::pair{"as sent", Measure::asSent},
          std::pair{"service", Measure::service}, std::pair{"refusals", Measure::refused},
          std::pair{"job: submit to result", Measure::jobResult},
          std::pair{"job: first event", Measure::jobFirstEvent},
          std::pair{"job: cancel", Measure::jobCancel}, std::pair{"slow clients", Measure::slow}}) {
        const Histogram& histogram = tally[measure];
        const bool optional = measure > Measure::service;
        if (optional && histogram.count() == 0) continue;
        std::vector<std::string> row{name};
        for (const double percent : toldPercentiles())
            row.push_back(timeText(histogram.percentile(percent)));
        row.push_back(histogram.count() == 0 ? "n/a" : timeText(histogram.max()));
        row.push_back(std::to_string(histogram.count()));
        rows.push_back(std::move(row));
    }
    return rows;
}

/// "connect 81 us / 95 us, ...": p50 and p99 of what has samples.
std::string phaseLine(const Tally& tally, std::initializer_list<Measure> measures) {
    std::string line;
    for (const Measure measure : measures) {
        const Histogram& histogram = tally[measure];
        if (histogram.count() == 0) continue;
        std::string name = nameOf(measure);
        if (name.starts_with("server_")) name.erase(0, 7);
        line += (line.empty() ? "" : ", ") + name + " " + timeText(histogram.valueAt(50)) + " / " +
                timeText(histogram.percentile(99));
    }
    return line;
}

std::string goodputLine(const LoadReport& report) {
    const LoadResult& result = report.result;
    const Tally& tally = result.tally;
    std::string line = "goodput  " + numberText(result.goodput(), 1) + "/s of " +
                       numberText(result.offered(), 1) + "/s offered";
    if (report.plan.sloLimit < Histogram::kHighest)
        line += ", within " + timeText(report.plan.sloLimit);
    line += "; " + std::to_string(result.verified) + " answers verified";
    line += "\nerrors   " +
            (tally.judged() == 0 ? "n/a" : numberText(100 * tally.errorRate(), 2) + " %");
    const std::string list = errorList(tally);
    if (!list.empty()) line += ": " + list;
    for (const auto& [name, count] :
         {std::pair{"aborted", tally.aborted}, std::pair{"jobs abandoned", tally.abandoned},
          std::pair{"jobs cancelled", tally.cancelled}, std::pair{"slow clients", tally.slow}})
        if (count > 0) line += std::string("; on purpose ") + name + " x" + std::to_string(count);
    if (tally.jobs > 0 && tally.polls > 0)
        line += "\njobs     " +
                numberText(static_cast<double>(tally.polls) / static_cast<double>(tally.jobs), 1) +
                " polls a job";
    return line + "\n";
}

std::string healthLine(const LoadResult& result) {
    const GeneratorHealth& health = result.health;
    const Histogram& lag = result.tally[Measure::lag];
    const std::string late = lag.count() == 0 ? "n/a" : timeText(lag.valueAt(99));
    return "generator  send lag p99 " + late + ", late " + numberText(100 * health.lateShare, 2) +
           " %, CPU " + numberText(100 * health.cpu, 0) + " %, not sent " +
           std::to_string(health.notSent) + "\n";
}

std::string wordsBelow(const LoadReport& report) {
    const Tally& tally = report.result.tally;
    std::string text;
    const std::string phases = phaseLine(
        tally, {Measure::connect, Measure::tls, Measure::upload, Measure::wait, Measure::download});
    if (!phases.empty()) text += "phases (p50 / p99)  " + phases + "\n";
    const std::string server =
        phaseLine(tally, {Measure::serverQueue, Measure::serverCompute, Measure::serverOverhead});
    if (!server.empty()) text += "server (p50 / p99)  " + server + "\n";
    text += goodputLine(report) + healthLine(report.result);
    for (const std::string& line : verdictLines(report)) text += line + "\n";
    return text;
}

}  // namespace

const std::vector<double>& toldPercentiles() {
    static const std::vector<double> kTold{50, 90, 95, 99, 99.9, 99.99};
    return kTold;
}

std::vector<std::string> verdictLines(const LoadReport& report) {
    std::vector<std::string> lines;
    const GeneratorHealth& health = report.result.health;
    if (!health.valid) lines.push_back("INVALID: " + health.reason);
    if (const std::string none = whatIsMissing(report.result); !none.empty())
        lines.push_back("MISSED   " + none);
    for (const Judgement& one : report.judgements)
        lines.push_back((one.kept ? "kept     " : "MISSED   ") + describe(one));
    return lines;
}

std::string errorList(const Tally& tally) {
    std::vector<std::pair<std::string, std::uint64_t>> errors(tally.errors.begin(),
                                                              tally.errors.end());
    std::stable_sort(errors.begin(), errors.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
    std::string text;
    for (const auto& [name, count] : errors)
        text += (text.empty() ? "" : ", ") + name + " x" + std::to_string(count);
    return text;
}

std::string describeLoad(const LoadPlan& plan) {
    const ArrivalPlan& arrivals = plan.arrivals;
    std::string text = nameOf(arrivals.kind);
    if (arrivals.kind == Arrivals::closed)
        text += ", " + std::to_string(arrivals.concurrency) + " in flight";
    else if (arrivals.kind != Arrivals::replay)
        text += ", " + numberText(arrivals.rate, 3) + "/s";
    return text + ", " + numberText(plan.duration.count(), 1) + " s after " +
           numberText(plan.warmup.count(), 1) + " s of warm-up";
}

std::string reportTable(const LoadReport& report) {
    std::string names;
    for (const std::string& name : report.plan.mix.mix.names())
        names += (names.empty() ? "" : ", ") + name;
    return printable(names + " at " + toText(report.plan.target.endpoint)) + ": " +
           describeLoad(report.plan) + "\n" + alignedTable(latencyRows(report.result.tally)) +
           wordsBelow(report);
}

std::string reportMarkdown(const LoadReport& report) {
    std::string text = "# Load test\n\n" + describeLoad(report.plan) + " at " +
                       markdownCell(toText(report.plan.target.endpoint)) + "\n\n" +
                       markdownTable(latencyRows(report.result.tally)) + "\n```\n" +
                       wordsBelow(report) + "```\n\n";
    std::vector<std::vector<std::string>> rows{{"entry", "planned", "good", "p50", "p99"}};
    const auto names = report.plan.mix.mix.names();
    for (std::size_t i = 0; i < names.size(); ++i) {
        const EntryTally& entry = report.result.tally.entries[i];
        rows.push_back({names[i], std::to_string(entry.planned), std::to_string(entry.good),
                        timeText(entry.corrected.percentile(50)),
                        timeText(entry.corrected.percentile(99))});
    }
    text += markdownTable(rows) + "\n";
    rows = {{"environment", ""}};
    for (const auto& [name, value] : report.environment.items())
        rows.push_back(
            {name, value.is_string() ? value.get<std::string>() : proto::writeJson(value)});
    rows.push_back(
        {"server", report.server.is_null() ? "unknown" : proto::writeJson(report.server)});
    rows.push_back({"seed", std::to_string(report.plan.seed)});
    return text + markdownTable(rows);
}

}  // namespace rivage::client::load
