#include <doctest/doctest.h>
#include <atomic>

#include <numeric>
#include <vector>

#include "core/base/options.h"
#include "core/base/parallel.h"
#include "core/base/report.h"

using namespace rivage::core;

TEST_SUITE("core/base") {
    TEST_CASE("parallelBlocks: every element once, in blocks that ignore the threads") {
        for (const int threads : {1, 2, 7})
            for (const std::size_t count : {0, 1, 99, 100, 101, 1000}) {
                std::vector<int> visits(count, 0);
                parallelBlocks(count, 100, threads, [&](std::size_t begin, std::size_t end) {
                    CHECK(begin % 100 == 0);
                    CHECK(end - begin <= 100);
                    for (std::size_t i = begin; i < end; ++i) ++visits[i];
                });
                CHECK(std::accumulate(visits.begin(), visits.end(), std::size_t{0}) == count);
                for (const int v : visits) CHECK(v == 1);
            }
    }

    TEST_CASE("parallelFor: stops when asked, and says so") {
        int polls = 0;
        const RunContext run{.stopRequested = [&] { return ++polls > 2; }};
        int visited = 0;
        CHECK_FALSE(parallelFor(
            1000, run, [&](std::size_t) { ++visited; }, 10));
        CHECK(visited == 20);
        CHECK(run.stopError().code == ErrorCode::cancelled);
        const RunContext late{.stopReason = [] { return ErrorCode::timedOut; }};
        CHECK(late.stopError().code == ErrorCode::timedOut);
    }

    TEST_CASE("parallelBlocks: the workers of a run poll it, those of a number do not") {
        for (const int threads : {1, 2, 7}) {
            std::atomic<int> polls{0};
            const RunContext run{.threads = threads, .stopRequested = [&] { return ++polls > 3; }};
            std::atomic<int> blocks{0};
            CHECK_FALSE(parallelBlocks(1000, 10, run, [&](std::size_t, std::size_t) { ++blocks; }));
            CHECK(blocks == 3);
            CHECK(parallelBlocks(1000, 10, threads, [&](std::size_t, std::size_t) { ++blocks; }));
            CHECK(blocks == 103);
        }
    }

    TEST_CASE("serialFor: every element in order, until it is asked to stop") {
        std::vector<std::size_t> seen;
        CHECK(serialFor(
            25, 1, [&](std::size_t i) { seen.push_back(i); }, 10));
        std::vector<std::size_t> expected(25);
        std::iota(expected.begin(), expected.end(), std::size_t{0});
        CHECK(seen == expected);
        int polls = 0;
        const RunContext run{.stopRequested = [&] { return ++polls > 2; }};
        seen.clear();
        CHECK_FALSE(serialFor(
            25, run, [&](std::size_t i) { seen.push_back(i); }, 10));
        CHECK(seen.size() == 20);
    }

    TEST_CASE("determinism: blocked sums have the same bits for threads 1, 2, 7") {
        std::vector<double> terms(100000);
        for (std::size_t i = 0; i < terms.size(); ++i)
            terms[i] = 1.0 / static_cast<double>(i * i % 977 + 1) - 0.3;
        const auto sum = [&](int threads) {
            return blockedSum(terms.size(), threads, 0.0, [&](std::size_t begin, std::size_t end) {
                return std::accumulate(terms.data() + begin, terms.data() + end, 0.0);
            });
        };
        CHECK(sum(1) == sum(2));
        CHECK(sum(1) == sum(7));
        CHECK(sum(1) == doctest::Approx(std::accumulate(terms.begin(), terms.end(), 0.0)));
    }

    TEST_CASE("presets: paper is the published setting, studio the default") {
        const MethodOptions paper = presetOptions(Preset::paper);
        CHECK(paper.energy.alpha == 0.001);
        CHECK(paper.energy.beta == 1);
        CHECK(paper.energy.gamma == 0.05);
        CHECK(paper.energy.fairness == Fairness::umbrella);
        CHECK_FALSE(paper.solve.displacementLimit.has_value());
        const MethodOptions studio = presetOptions(Preset::studio);
        CHECK(studio.energy.alpha == 0.01);
        CHECK(studio.energy.fairness == Fairness::tangential);
        CHECK(studio.solve.displacementLimit == 0.49);
    }

    TEST_CASE("report: times and bytes are there exactly when they are known") {
        ConversionReport report;
        report.input.labels = {{"sea", 3}, {"island", 4}};
        report.output.closed = {true, false};
        auto json = toJson(report);
        CHECK_FALSE(json.contains("milliseconds"));
        CHECK_FALSE(json["output"].contains("bytes"));
        CHECK(json["closed"]["sea"] == true);
        CHECK(json["closed"]["island"] == false);
        report.milliseconds = {1, 2, 3, 4, 5, 6, 7};
        report.output.bytes = 9;
        json = toJson(report);
        CHECK(json["milliseconds"]["parse"] == 1);
        CHECK_FALSE(json["milliseconds"].contains("emboss"));
        CHECK(json["milliseconds"]["write"] == 7);
        CHECK(json["milliseconds"]["total"] == 23);
        report.emboss.emplace();
        json = toJson(report);
        CHECK(json["milliseconds"]["emboss"] == 5);
        CHECK(json["milliseconds"]["total"] == 28);
        CHECK(json["output"]["bytes"] == 9);
    }
}
