#include "client/load/search.h"

#include <doctest/doctest.h>

namespace rivage::client::load {
namespace {

/// Windows with so many good answers each, all of one latency.
std::vector<Second> windows(std::initializer_list<std::pair<int, std::int64_t>> list) {
    std::vector<Second> result;
    for (const auto& [good, latency] : list) {
        Second second;
        second.good = static_cast<std::uint64_t>(good);
        second.corrected.emplace_back(Histogram::indexOf(latency), second.good);
        result.push_back(second);
    }
    return result;
}

/// Looks for the knee of a server that keeps every rate up to `knee`.
SearchResult search(double knee, double from, bool late = false) {
    const LoadPlan load{Target(), PreparedMix{{}, {}, HeadWriter("x", "")}, ArrivalPlan()};
    SearchPlan plan{.load = load};
    plan.from = from;
    plan.to = 1000;
    return findKnee(
        plan,
        [&](double rate) {
            RatePoint point{.rate = rate};
            point.kept = rate <= knee;
            point.result.health.valid = !late;
            return point;
        },
        [] { return false; });
}

TEST_SUITE("client/load") {
    TEST_CASE("search: finds the knee from below and from above") {
        for (const double from : {1.0, 30.0, 37.0, 200.0}) {
            CAPTURE(from);
            const SearchResult result = search(37, from);
            CHECK(result.knee <= 37);
            CHECK(result.knee > 37 / 1.06);
            CHECK(exitOf(SearchResult{.capacity = 1, .knee = result.knee}) == LoadExit::ok);
        }
    }

    TEST_CASE("search: no rate at all, and no end") {
        CHECK(search(0, 10).knee == 0);
        CHECK(exitOf(SearchResult{.capacity = 1}) == LoadExit::missed);
        CHECK(exitOf(SearchResult{}) == LoadExit::unreachable);
        CHECK(search(1e9, 10).knee == 640);  // the highest that may be tried
    }

    TEST_CASE("search: a generator that is always late is not asked for long, nor believed") {
        const SearchResult result = search(37, 1, true);
        CHECK(result.steps.size() == 3);
        CHECK_FALSE(result.valid);
        const LoadPlan load{Target(), PreparedMix{{}, {}, HeadWriter("x", "")}, ArrivalPlan()};
        CHECK(curveMarkdown({.load = load}, result).starts_with("not valid"));
    }

    TEST_CASE("search: a shortage of the generator's makes no knee") {
        const LoadPlan load{Target(), PreparedMix{{}, {}, HeadWriter("x", "")}, ArrivalPlan()};
        for (const double few : {0.0, 20.0}) {  // kept up to that rate, and then out of files
            CAPTURE(few);
            const SearchResult result = findKnee(
                {.load = load, .from = 5},
                [&](double rate) {
                    RatePoint point{.rate = rate, .kept = rate <= few};
                    if (point.kept) return point;
                    point.result.health = {.shortage = {24, 1}, .valid = false, .reason = "files"};
                    return point;
                },
                [] { return false; });
            SearchResult judged = result;
            judged.capacity = 100;
            CHECK(exitOf(judged) == LoadExit::late);
            CHECK(curveMarkdown({.load = load}, judged).starts_with("not valid: files\n"));
        }
    }

    TEST_CASE("report: a rate without answers has no times, in no form") {
        const LoadPlan load{Target(), PreparedMix{{}, {}, HeadWriter("x", "")}, ArrivalPlan()};
        SearchResult result{.steps = {{.rate = 5}}, .curve = {{.rate = 10}}};
        const SearchPlan plan{.load = load, .curve = {1}};
        const proto::Json json = searchJson(plan, result);
        for (const char* list : {"steps", "curve"}) {
            CHECK(json[list][0]["p50_us"].is_null());
            CHECK(json[list][0]["slo_percentile_us"].is_null());
        }
        CHECK(curveMarkdown(plan, result)
                  .find("| 1x | 10 | 0 | 0 | n/a | n/a | 0 | 0 | n/a | n/a |") !=
              std::string::npos);
        result.curve[0].latency.record(7);
        CHECK(searchJson(plan, result)["curve"][0]["p50_us"] == 7);
    }

    TEST_CASE("search: three windows agree if the goodput and the median are within 10 %") {
        CHECK_FALSE(windowsAgree(windows({{100, 50}, {100, 50}})));
        CHECK(windowsAgree(windows({{100, 500}, {105, 510}, {95, 490}})));
        CHECK(windowsAgree(windows({{1, 5}, {100, 500}, {105, 510}, {95, 490}})));
        CHECK_FALSE(windowsAgree(windows({{100, 500}, {100, 500}, {130, 500}})));
        CHECK_FALSE(windowsAgree(windows({{100, 500}, {100, 500}, {100, 700}})));
    }
}

}  // namespace
}  // namespace rivage::client::load
