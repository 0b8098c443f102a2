#include "client/load/schedule.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace rivage::client::load {
namespace {

/// The first arrivals of all threads, by time.
std::vector<Nanoseconds> arrivals(const ArrivalPlan& plan, int threads, int each) {
    std::vector<Nanoseconds> all;
    for (int thread = 0; thread < threads; ++thread) {
        Schedule schedule(plan, thread, threads, 77 + static_cast<std::uint64_t>(thread));
        for (int i = 0; i < each; ++i) all.push_back(schedule.next().at);
    }
    std::sort(all.begin(), all.end());
    return all;
}

TEST_SUITE("client/load") {
    TEST_CASE("schedule: a constant rate is exact, also after a million sends") {
        const ArrivalPlan plan{.kind = Arrivals::constant, .rate = 300};
        for (const int threads : {1, 3}) {
            CAPTURE(threads);
            const auto all = arrivals(plan, threads, 1'000'000 / threads);
            for (std::size_t i = 0; i < all.size(); i += 9973)
                CHECK(all[i].count() == std::llround(static_cast<double>(i) / 300 * 1e9));
        }
    }

    TEST_CASE("schedule: the gaps of a Poisson process have the mean and the variance of one") {
        const ArrivalPlan plan{.kind = Arrivals::poisson, .rate = 1000};
        for (const int threads : {1, 4}) {
            CAPTURE(threads);
            auto all = arrivals(plan, threads, 200'000 / threads);
            all.resize(150'000);  // later, threads that were faster have come to their end
            std::vector<double> gaps;
            for (std::size_t i = 1; i < all.size(); ++i)
                gaps.push_back(static_cast<double>((all[i] - all[i - 1]).count()) / 1e9);
            double mean = 0;
            for (const double gap : gaps) mean += gap / static_cast<double>(gaps.size());
            double variance = 0;
            for (const double gap : gaps)
                variance += (gap - mean) * (gap - mean) / static_cast<double>(gaps.size());
            CHECK(std::abs(mean / 1e-3 - 1) < 0.01);
            CHECK(std::abs(variance / 1e-6 - 1) < 0.03);
        }
    }

    TEST_CASE("determinism: the same seed gives the same times") {
        const ArrivalPlan plan{.kind = Arrivals::poisson, .rate = 10};
        Schedule a(plan, 0, 1, 5);
        Schedule b(plan, 0, 1, 5);
        Schedule c(plan, 0, 1, 6);
        const Nanoseconds first = a.next().at;
        CHECK(first == b.next().at);
        CHECK(first != c.next().at);
    }

    TEST_CASE("schedule: a trace is shared out, and ends") {
        const auto trace =
            parseTrace("# s, entry\n10.5\n 11 , b # late\n\n11.25,a\r\n", {"a", "b"});
        REQUIRE(trace);
        const ArrivalPlan plan{.kind = Arrivals::replay, .trace = *trace};
        Schedule even(plan, 0, 2, 1);
        Schedule odd(plan, 1, 2, 1);
        CHECK(even.next().at.count() == 0);
        const Arrival second = odd.next();
        CHECK(second.at.count() == 500'000'000);
        CHECK(second.entry == 1);
        const Arrival third = even.next();
        CHECK(third.at.count() == 750'000'000);
        CHECK(third.entry == 0);
        CHECK(odd.next().at == kNever);
    }

    TEST_CASE("reject: traces that are none") {
        for (const char* text :
             {"", "# nothing\n", "x\n", "1\n0.5\n", "1,c\n", "1e99\n", "nan\n"}) {
            CAPTURE(text);
            const auto trace = parseTrace(text, {"a"});
            REQUIRE_FALSE(trace);
            CHECK(trace.error().exit == ExitCode::usage);
        }
        CHECK(describe(parseTrace("1\n0.5\n", {}).error()).find("line 2") != std::string::npos);
    }
}

}  // namespace
}  // namespace rivage::client::load
