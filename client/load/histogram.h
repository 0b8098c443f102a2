#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "proto/json.h"

namespace rivage::client::load {

/// Counts of times from 1 us to 1 h in buckets that are linear within each power of two, so that
/// three significant digits are kept (the form of Gil Tene's HdrHistogram). What is outside is
/// counted in the first or the last bucket; the smallest and the largest value are exact.
class Histogram {
public:
    static constexpr std::int64_t kLowest = 1;
    static constexpr std::int64_t kHighest = 3'600'000'000;
    /// Buckets of one power of two; half of them are below the next smaller one.
    static constexpr int kSubBuckets = 2048;
    /// A percentile is only told with so many samples above it.
    static constexpr double kSamplesAbove = 10;

    /// A bucket by its index, with its count.
    using Bucket = std::pair<std::uint32_t, std::uint64_t>;

    /// @param value  us
    void record(std::int64_t value, std::uint64_t times = 1);
    void merge(const Histogram& other);

    [[nodiscard]] std::uint64_t count() const { return count_; }
    [[nodiscard]] std::int64_t min() const { return count_ == 0 ? 0 : min_; }
    [[nodiscard]] std::int64_t max() const { return max_; }
    [[nodiscard]] double mean() const;
    [[nodiscard]] double deviation() const;

    /// The value that `percent` of all samples do not exceed, in us; 0 without samples.
    [[nodiscard]] std::int64_t valueAt(double percent) const;
    /// The same; nothing if fewer than `kSamplesAbove` samples are above it.
    [[nodiscard]] std::optional<std::int64_t> percentile(double percent) const;

    /// The buckets that are not empty, by rising index.
    [[nodiscard]] std::vector<Bucket> buckets() const;
    void add(const std::vector<Bucket>& buckets);

    /// Everything that is known: `readHistogram` gives the same histogram again.
    [[nodiscard]] proto::Json toJson() const;
    /// The percentile spectrum in the text form that hdrplot reads, in ms.
    [[nodiscard]] std::string toHgrm() const;

    /// The bucket of a value, and the largest value of a bucket.
    [[nodiscard]] static std::uint32_t indexOf(std::int64_t value);
    [[nodiscard]] static std::int64_t highestOf(std::uint32_t index);

private:
    friend core::Result<Histogram> readHistogram(const proto::Json& json);

    std::vector<std::uint64_t> counts_;  ///< empty until the first sample
    std::uint64_t count_ = 0;
    std::int64_t min_ = kHighest;
    std::int64_t max_ = 0;
    double sum_ = 0;
};

/// @errors malformedRequest if this is not what `Histogram::toJson` writes
core::Result<Histogram> readHistogram(const proto::Json& json);

}  // namespace rivage::client::load
