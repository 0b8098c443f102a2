#include "client/load/report.h"

#include <doctest/doctest.h>

#include "client/load/plot.h"

namespace rivage::client::load {
namespace {

LoadPlan plan() {
    Mix mix = plainMix("/version");
    LoadPlan result{{.endpoint = {"127.0.0.1", 8080}},
                    {mix, {{.entry = mix.entries[0]}}, HeadWriter("x", "")},
                    {.kind = Arrivals::constant, .rate = 200}};
    result.sloLimit = 100'000;
    return result;
}

/// 2000 answers of 1 to 2000 us when they were sent, each 5 ms later than planned, 10 refusals.
LoadResult figures() {
    LoadResult result;
    result.duration = 10;
    Tally& tally = result.tally;
    tally.entries.resize(1);
    for (int i = 1; i <= 2000; ++i) {
        tally[Measure::corrected].record(5000 + i);
        tally[Measure::asSent].record(i);
        tally[Measure::service].record(i);
        tally[Measure::lag].record(5000);
    }
    for (int i = 0; i < 10; ++i) tally[Measure::refused].record(700);
    tally[Measure::wait].merge(tally[Measure::asSent]);
    tally.planned = tally.sent = 2011;
    tally.good = tally.withinSlo = 2000;
    tally.refused = 10;
    tally.failed = 1;
    tally.aborted = 0;
    tally.errors = {{"503-shed busy", 10}, {"timeout", 1}};
    tally.statuses = {{200, 2000}, {503, 10}};
    result.verified = 100;
    result.health = {.lateShare = 0.995, .cpu = 0.12, .valid = false, .reason = "too slow"};
    result.seconds.resize(2);
    result.seconds[0].good = 1;
    result.seconds[0].corrected = {{Histogram::indexOf(700), 1}};
    return result;
}

TEST_SUITE("client/load") {
    TEST_CASE("golden: the table") {
        const LoadPlan load = plan();
        const LoadResult result = figures();
        const LoadReport report{
            load, result, judge({{"errors", 0.001}, {"goodput", 20}}, Slo{99, 100'000}, result)};
        CHECK(
            reportTable(report) ==
            R"(/version at http://127.0.0.1:8080: open loop, constant rate, 200/s, 10 s after 1 s of warm-up
latency        p50      p90      p95      p99  p99.9  p99.99      max  samples
corrected  6.00 ms  6.80 ms  6.90 ms  6.98 ms    n/a     n/a  7.00 ms     2000
as sent    1.00 ms  1.80 ms  1.90 ms  1.98 ms    n/a     n/a  2.00 ms     2000
service    1.00 ms  1.80 ms  1.90 ms  1.98 ms    n/a     n/a  2.00 ms     2000
refusals       n/a      n/a      n/a      n/a    n/a     n/a   700 us       10
phases (p50 / p99)  wait 1.00 ms / 1.98 ms
goodput  200/s of 201.1/s offered, within 100 ms; 100 answers verified
errors   0.55 %: 503-shed busy x10, timeout x1
generator  send lag p99 5.00 ms, late 99.5 %, CPU 12 %, not sent 0
INVALID: too slow
MISSED   errors = 0.547 %, at most 0.1 %
kept     goodput = 200/s, at least 20/s
kept     p99 = 6.98 ms, at most 100 ms
)");
    }

    TEST_CASE("report: JSON says the same, and its histograms can be read back") {
        const LoadPlan load = plan();
        const LoadResult result = figures();
        const proto::Json json = reportJson({load, result, {}});
        CHECK(json["plan"]["mode"] == "open loop, constant rate");
        CHECK(json["latency_us"]["corrected"]["p99.9"].is_null());
        CHECK(json["errors"]["503-shed busy"] == 10);
        CHECK(json["exit_code"] == 3);
        const auto histogram = readHistogram(json["histograms"]["corrected"]);
        REQUIRE(histogram);
        CHECK(histogram->valueAt(99) == result.tally[Measure::corrected].valueAt(99));
    }

    TEST_CASE("golden: a line of CSV a second, with what the server said") {
        const LoadPlan load = plan();
        LoadResult result = figures();
        result.metrics = {{{"rivage_queue_depth", 9}}, {{"rivage_queue_depth", 3}}};
        CHECK(reportCsv({load, result, {}}) ==
              "second,ended,good,within_slo,refused,failed,bytes_in,p50_us,p99_us,max_us,"
              "rivage_queue_depth\n"
              "0,0,1,0,0,0,0,,,700,3\n"
              "1,0,0,0,0,0,0,,,,\n");
    }

    TEST_CASE("verdict: thresholds, and which exit code comes first") {
        LoadResult result = figures();
        result.health.valid = true;
        const auto kept = [&](const Threshold& threshold) {
            return judge({threshold}, {}, result).front().kept;
        };
        CHECK(kept({"p99", 7000}));
        CHECK_FALSE(kept({"p99", 6900}));
        CHECK_FALSE(kept({"p99.9", 1e9}));  // nobody can say
        CHECK(kept({"max", 7000}));
        CHECK(kept({"refused", 0.005}));
        CHECK_FALSE(kept({"refused", 0.004}));
        CHECK(kept({"not_sent", 0}));
        CHECK_FALSE(kept({"goodput", 201}));
        CHECK(exitOf(result, {}) == LoadExit::ok);
        CHECK(exitOf(result, judge({{"goodput", 201}}, {}, result)) == LoadExit::missed);
        CHECK(exitOf(Failure{ExitCode::refused}) == LoadExit::usage);
        CHECK(exitOf(Failure{ExitCode::unreachable}) == LoadExit::unreachable);
    }

    TEST_CASE("report: what was found wrong is no goodput") {
        LoadResult result = figures();
        result.tally.errors["invalid-glb"] = 500;
        CHECK(result.goodput() == doctest::Approx(150));
    }

    TEST_CASE("report: a run without answers has no times, in no form") {
        const LoadPlan load = plan();
        LoadResult result;
        result.tally.entries.resize(1);
        const LoadReport report{load, result,
                                judge({{"errors", 1}, {"p50", 1e9}, {"refused", 1}}, {}, result)};
        for (const std::string& text : {reportTable(report), reportMarkdown(report)}) {
            CAPTURE(text);
            CHECK(text.find("errors   n/a\n") != std::string::npos);
            CHECK(text.find("send lag p99 n/a") != std::string::npos);
            CHECK(text.find(" us") == std::string::npos);
            CHECK(text.find("kept") == std::string::npos);
        }
        const proto::Json json = reportJson(report);
        CHECK(json["error_rate"].is_null());
        CHECK(json["entries"][0]["corrected"]["mean"].is_null());
    }

    TEST_CASE("report: bytes that are not UTF-8 do not end the program") {
        const LoadPlan load = plan();
        const LoadResult result = figures();
        const proto::Json odd{{"a", {"\xff"}}};
        CHECK(reportMarkdown({load, result, {}, odd, odd}).find("\xef\xbf\xbd") !=
              std::string::npos);
    }

    TEST_CASE("report: names and servers say nothing to a terminal or to Markdown") {
        LoadPlan load = plan();
        load.mix.mix.entries[0].name = "a\x1b[2J\xc2\x9b|<b>\n# x `y`";
        LoadResult result = figures();
        const proto::Json odd{{"version", "\x1b]0;x\x07|<script>"}};
        const LoadReport report{load, result, {}, odd, odd};
        const std::string markdown = reportMarkdown(report);
        const std::string table = reportTable(report);
        for (const std::string& text : {table, markdown}) {
            CAPTURE(text);
            for (const char* bad : {"\x1b", "\x07", "\xc2\x9b", "\n# x"})
                CHECK(text.find(bad) == std::string::npos);
        }
        CHECK(markdown.find("a?\\[2J?\\|&lt;b>?# x \\`y\\`") != std::string::npos);
        CHECK(markdown.find("<script>") == std::string::npos);
        const std::string svg = drawSvg({{"<t>\x1b&", {{"n\x1b<", "#111", {{1, 1}}}}, {}}});
        CHECK(svg.find("&lt;t>?&amp;") != std::string::npos);
        CHECK(svg.find("n?&lt;") != std::string::npos);
    }

    TEST_CASE("verdict: a run in which nothing was good is none that was kept") {
        LoadResult result = figures();
        result.health.valid = true;
        result.tally.good = 0;
        CHECK(exitOf(result, {}) == LoadExit::missed);
        result.tally.statuses.clear();
        result.tally.failed = result.tally.planned;
        CHECK(exitOf(result, {}) == LoadExit::unreachable);
        CHECK(whatIsMissing(result) == "no server answered");
        LoadResult nothing;
        CHECK(exitOf(nothing, {}) == LoadExit::missed);
        nothing.tally.planned = nothing.tally.aborted = 5;  // on purpose
        CHECK(exitOf(nothing, {}) == LoadExit::ok);
        const LoadPlan load = plan();
        nothing.tally = {};
        nothing.tally.entries.resize(1);
        CHECK(reportTable({load, nothing, {}}).find("MISSED   nothing was sent") !=
              std::string::npos);
    }

    TEST_CASE("plot: both lines, and no file of nonsense without samples") {
        const std::string svg = drawLatency(figures());
        CHECK(svg.starts_with("<svg "));
        CHECK(svg.find(">corrected<") != std::string::npos);
        CHECK(svg.find(">as sent<") != std::string::npos);
        CHECK(svg.find("99.9 %") != std::string::npos);
        for (const std::string& text : {svg, drawLatency(LoadResult())}) {
            CHECK(text.find("nan") == std::string::npos);
            CHECK(text.find("inf") == std::string::npos);
            CHECK(text.ends_with("</svg>\n"));
        }
    }
}

}  // namespace
}  // namespace rivage::client::load
