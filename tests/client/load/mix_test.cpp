#include "client/load/mix.h"

#include <doctest/doctest.h>

#include <cmath>

#include "client/load/histogram.h"

namespace rivage::client::load {
namespace {

TEST_SUITE("client/load") {
    TEST_CASE("mix: everything that a mix can say") {
        const auto mix = parseMix(R"({
            "seed": 9, "duplicates": 0.25, "aborts": 0.1, "abort_after": "20ms",
            "slow_clients": 0.05, "slow_rate": 1000, "slo": "p99=2s",
            "entries": [
                {"name": "a", "weight": 3, "input": {"sample": "house"},
                 "options": {"alpha": 0.02, "compression": "none"}},
                {"mode": "job", "input": {"file": "x.vox"}, "follow": "poll", "poll_every": "1s",
                 "abandoned": 0.1, "cancelled": 0.2, "cancel_after": "50ms"},
                {"mode": "get", "path": "/version"}],
            "thresholds": {"p99.9": "500ms", "errors": 0.001, "goodput": 20}})",
                                  "m.json");
        REQUIRE(mix);
        CHECK(mix->names() == std::vector<std::string>{"a", "x.vox", "/version"});
        CHECK(mix->entries[0].options.size() == 2);
        CHECK(mix->entries[0].options[0].value == "0.02");
        CHECK(mix->entries[1].mode == Mode::job);
        CHECK(mix->entries[1].follow == Follow::poll);
        CHECK(mix->entries[1].pollEvery == std::chrono::seconds(1));
        CHECK(mix->entries[1].cancelled == 0.2);
        CHECK(mix->slo->limit == 2'000'000);
        CHECK(mix->seed == 9U);
        REQUIRE(mix->thresholds.size() == 3);
        CHECK(mix->thresholds[0].limit == 500'000);
    }

    TEST_CASE("reject: mixes that say something wrong, by the name of the member") {
        const auto field = [](const std::string& text) {
            const auto mix = parseMix(text, "m.json");
            REQUIRE_FALSE(mix);
            CHECK(mix.error().exit == ExitCode::usage);
            return textOf(mix.error().problem, "field");
        };
        const auto entry = [&](const std::string& members) {
            return field(R"({"entries":[{)" + members + "}]}");
        };
        CHECK(field("[]") == "");
        CHECK(field("{}") == "/entries");
        CHECK(field(R"({"entries":[]})") == "/entries");
        CHECK(field(R"({"entries":[1]})") == "/entries/0");
        CHECK(entry(R"("weigth":1)") == "/entries/0/weigth");
        CHECK(entry(R"("weight":-1)") == "/entries/0/weight");
        CHECK(entry(R"("weight":0)") == "/entries");
        CHECK(entry(R"("mode":"async")") == "/entries/0/mode");
        CHECK(entry(R"("mode":"get")") == "/entries/0/path");
        CHECK(entry(R"("mode":"get","path":"version")") == "/entries/0/path");
        for (const char* path : {"/a b", "/a\\r\\nX: y", "/\\u007f", "/\\u00e9"})
            CHECK(entry(R"("mode":"get","path":")" + std::string(path) + "\"") ==
                  "/entries/0/path");
        CHECK(entry(R"("mode":"get","path":"/","options":{})") == "/entries/0/options");
        CHECK(entry(R"("follow":"poll")") == "/entries/0/follow");
        CHECK(entry(R"("mode":"job","abandoned":0.6,"cancelled":0.6)") == "/entries/0/cancelled");
        CHECK(entry(R"("mode":"job","poll_every":100)") == "/entries/0/poll_every");
        CHECK(entry(R"("input":{})") == "/entries/0/input");
        CHECK(entry(R"("input":{"sample":"a","file":"b"})") == "/entries/0/input");
        CHECK(entry(R"("input":{"path":"b"})") == "/entries/0/input/path");
        CHECK(entry(R"("options":{"alphaa":1})") == "/entries/0/options/alphaa");
        CHECK(entry(R"("options":{"alpha":"much"})") == "/entries/0/options/alpha");
        CHECK(field(R"({"entries":[{"name":"a"},{"name":"a"}]})") == "/entries/1/name");
        CHECK(field(R"({"entries":[{}],"duplicates":1.5})") == "/duplicates");
        CHECK(field(R"({"entries":[{}],"slo":"fast"})") == "/slo");
        CHECK(field(R"({"entries":[{}],"seed":-1})") == "/seed");
        CHECK(field(R"({"entries":[{}],"thresholds":{"p99":0.5}})") == "/thresholds/p99");
        CHECK(field(R"({"entries":[{}],"thresholds":{"p99":"0.4us"}})") == "/thresholds/p99");
        CHECK(entry(R"("mode":"job","poll_every":"0.4ms")") == "/entries/0/poll_every");
        for (const char* number : {"NaN", "Infinity", "1e999", "-1e999"}) {
            CAPTURE(number);
            CHECK_FALSE(parseMix(std::string(R"({"entries":[{"weight":)") + number + "}]}", "m"));
        }
        CHECK(field(R"({"entries":[{}],"thresholds":{"p100":"1s"}})") == "/thresholds/p100");
        CHECK(field(R"({"entries":[{}],"thresholds":{"errors":2}})") == "/thresholds/errors");
        CHECK(field(R"({"entries":[{}],"extra":1})") == "/extra");
    }

    TEST_CASE("units: times and percentiles") {
        CHECK(readTime("500ms") == 500'000);
        CHECK(readTime("1.5s") == 1'500'000);
        CHECK(readTime("250us") == 250);
        for (const char* text : {"", "5", "s", "-1s", "0ms", "2h", "7201s", "1 s", "nans"}) {
            CAPTURE(text);
            CHECK_FALSE(readTime(text));
        }
        // No clock here tells less than 1 us, and what is not whole must not be rounded up.
        for (const char* text : {"0.4us", "0.999us", "0.0009ms", "nanus", "infs", "1e-9s"}) {
            CAPTURE(text);
            CHECK_FALSE(readTime(text));
        }
        CHECK(readTime("1us") == 1);
        CHECK(readTime("1.9us") == 1);
        CHECK(readTime("0.0011s") == 1100);
        CHECK(readTime("3600s") == Histogram::kHighest);
        CHECK_FALSE(readSlo("p99=0.4us"));
        CHECK_FALSE(readSlo("pnan=1s"));
        for (const double percent : {50.0, 99.9, 99.99999, 1e-7}) {
            CAPTURE(percent);
            CHECK(readPercentile(percentileName(percent)) == percent);
        }
        CHECK(numberText(1e300).size() == 301);
        CHECK(numberText(std::nan("")) == "n/a");
        CHECK(readSlo("p99.9=1s")->percent == 99.9);
        for (const char* text : {"p99", "99=1s", "p0=1s", "p100=1s", "p99=1"}) {
            CAPTURE(text);
            CHECK_FALSE(readSlo(text));
        }
        CHECK(timeText(999) == "999 us");
        CHECK(timeText(4274) == "4.27 ms");
        CHECK(timeText(42'740) == "42.7 ms");
        CHECK(timeText(427'400) == "427 ms");
        CHECK(timeText(1'050'000) == "1.05 s");
        CHECK(timeText(std::optional<std::int64_t>()) == "n/a");
    }
}

}  // namespace
}  // namespace rivage::client::load
