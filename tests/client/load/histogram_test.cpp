#include "client/load/histogram.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

namespace rivage::client::load {
namespace {

/// Values over all nine powers of ten, with their sorted list.
struct Sampled {
    Histogram histogram;
    std::vector<std::int64_t> sorted;
};

Sampled sampled(unsigned seed, int count) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> exponent(0, std::log10(3.6e9));
    Sampled result;
    for (int i = 0; i < count; ++i) {
        const auto value = std::max<std::int64_t>(1, std::llround(std::pow(10, exponent(random))));
        result.sorted.push_back(value);
        result.histogram.record(value);
    }
    std::sort(result.sorted.begin(), result.sorted.end());
    return result;
}

TEST_SUITE("client/load") {
    TEST_CASE("histogram: each bucket begins where the one before ends") {
        for (std::uint32_t i = 1; i <= Histogram::indexOf(Histogram::kHighest); ++i) {
            const std::int64_t first = Histogram::highestOf(i - 1) + 1;
            if (i > 1) CHECK(Histogram::indexOf(first) == i);
            CHECK(Histogram::indexOf(std::min(Histogram::highestOf(i), Histogram::kHighest)) == i);
        }
    }

    TEST_CASE("differential: percentiles agree with sorted values to three digits") {
        for (const unsigned seed : {1U, 2U, 3U}) {
            CAPTURE(seed);
            const Sampled values = sampled(seed, 50'000);
            for (const double percent : {0.1, 1.0, 25.0, 50.0, 90.0, 99.0, 99.9, 99.99, 100.0}) {
                CAPTURE(percent);
                const auto rank = static_cast<std::size_t>(
                    std::ceil(percent / 100 * static_cast<double>(values.sorted.size()) - 1e-6));
                const auto exact = static_cast<double>(values.sorted[rank - 1]);
                const auto told = static_cast<double>(values.histogram.valueAt(percent));
                CHECK(told >= exact);
                CHECK(told <= exact * 1.001);
            }
            CHECK(values.histogram.min() == values.sorted.front());
            CHECK(values.histogram.max() == values.sorted.back());
        }
    }

    TEST_CASE("histogram: merging parts gives the whole") {
        Histogram whole;
        Histogram parts[2];
        for (std::int64_t i = 1; i < 9999; ++i) {
            whole.record(i * i);
            parts[i % 2].record(i * i);
        }
        parts[0].merge(parts[1]);
        parts[0].merge(Histogram());
        CHECK(parts[0].toJson() == whole.toJson());
    }

    TEST_CASE("histogram: JSON loses nothing") {
        const Histogram before = sampled(4, 3000).histogram;
        const auto after = readHistogram(proto::Json::parse(before.toJson().dump()));
        REQUIRE(after);
        CHECK(after->toJson() == before.toJson());
        CHECK(readHistogram(Histogram().toJson())->count() == 0);
    }

    TEST_CASE("reject: JSON that is no histogram") {
        for (const char* text :
             {"1", "{}", R"({"sub_buckets":1024,"counts":[]})",
              R"({"sub_buckets":2048,"counts":[[1]],"min":1,"max":1,"sum":1})",
              R"({"sub_buckets":2048,"counts":[[999999,1]],"min":1,"max":1,"sum":1})",
              R"({"sub_buckets":2048,"counts":[[1,1]],"min":"1","max":1,"sum":1})"}) {
            CAPTURE(text);
            CHECK_FALSE(readHistogram(proto::Json::parse(text)));
        }
    }

    TEST_CASE("histogram: a percentile needs ten samples above it") {
        Histogram histogram;
        for (int i = 0; i < 999; ++i) histogram.record(i + 1);
        CHECK_FALSE(histogram.percentile(99));
        histogram.record(1000);
        CHECK(histogram.percentile(99) == 990);
        CHECK_FALSE(histogram.percentile(99.9));
    }

    TEST_CASE("histogram: what is outside lands in the first and the last bucket") {
        Histogram histogram;
        histogram.record(-5);
        histogram.record(0);
        histogram.record(2 * Histogram::kHighest);
        CHECK(histogram.count() == 3);
        CHECK(histogram.min() == 1);
        CHECK(histogram.max() == Histogram::kHighest);
    }

    TEST_CASE("golden: the text form of a small histogram") {
        Histogram histogram;
        for (const std::int64_t value : {1000, 2000, 3000, 4000}) histogram.record(value);
        const std::string text = histogram.toHgrm();
        CHECK(
            text.starts_with("       Value     Percentile TotalCount 1/(1-Percentile)\n\n"
                             "       1.000 0.000000000000          1           1.00\n"));
        CHECK(text.find("       4.000 1.000000000000          4\n") != std::string::npos);
        CHECK(
            text.ends_with("#[Mean    =        2.500, StdDeviation   =        1.118]\n"
                           "#[Max     =        4.000, Total count    =            4]\n"
                           "#[Buckets =           22, SubBuckets     =         2048]\n"));
    }
}

}  // namespace
}  // namespace rivage::client::load
