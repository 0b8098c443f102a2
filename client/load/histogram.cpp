#include "client/load/histogram.h"

#include <cmath>
#include <cstdio>

namespace rivage::client::load {
namespace {

constexpr int kHalf = Histogram::kSubBuckets / 2;
constexpr int kSubBits = 11;  // log2 of kSubBuckets
static_assert(1 << kSubBits == Histogram::kSubBuckets);

std::int64_t middleOf(std::uint32_t index) {
    const std::int64_t high = Histogram::highestOf(index);
    const std::int64_t low = index == 0 ? 0 : Histogram::highestOf(index - 1) + 1;
    return low + (high - low) / 2;
}

}  // namespace

std::uint32_t Histogram::indexOf(std::int64_t value) {
    const auto inside = static_cast<std::uint64_t>(std::clamp(value, kLowest, kHighest));
    const int shift = std::max(0, static_cast<int>(std::bit_width(inside)) - kSubBits);
    return static_cast<std::uint32_t>(shift * kHalf + static_cast<int>(inside >> shift));
}

std::int64_t Histogram::highestOf(std::uint32_t index) {
    const int shift = std::max(0, static_cast<int>(index) / kHalf - 1);
    const std::int64_t sub = static_cast<std::int64_t>(index) - shift * kHalf;
    return ((sub + 1) << shift) - 1;
}

void Histogram::record(std::int64_t value, std::uint64_t times) {
    if (times == 0) return;
    value = std::clamp(value, kLowest, kHighest);
    if (counts_.empty()) counts_.resize(indexOf(kHighest) + 1);
    counts_[indexOf(value)] += times;
    count_ += times;
    min_ = std::min(min_, value);
    max_ = std::max(max_, value);
    sum_ += static_cast<double>(value) * static_cast<double>(times);
}

void Histogram::merge(const Histogram& other) {
    if (other.count_ == 0) return;
    if (counts_.empty()) counts_.resize(other.counts_.size());
    for (std::size_t i = 0; i < other.counts_.size(); ++i) counts_[i] += other.counts_[i];
    count_ += other.count_;
    min_ = std::min(min_, other.min_);
    max_ = std::max(max_, other.max_);
    sum_ += other.sum_;
}

double Histogram::mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }

double Histogram::deviation() const {
    if (count_ == 0) return 0;
    double squares = 0;
    for (const auto& [index, times] : buckets()) {
        const double distance = static_cast<double>(middleOf(index)) - mean();
        squares += distance * distance * static_cast<double>(times);
    }
    return std::sqrt(squares / static_cast<double>(count_));
}

std::int64_t Histogram::valueAt(double percent) const {
    if (count_ == 0) return 0;
    // The nudge keeps 99.9 % of 1000 from becoming 1000 by rounding up 999.0000001.
    const double exact = percent / 100 * static_cast<double>(count_);
    const auto wanted = static_cast<std::uint64_t>(std::max(1.0, std::ceil(exact - 1e-6)));
    std::uint64_t seen = 0;
    for (std::uint32_t i = 0; i < counts_.size(); ++i) {
        seen += counts_[i];
        if (seen >= wanted) return std::min(highestOf(i), max_);
    }
    return max_;
}

std::optional<std::int64_t> Histogram::percentile(double percent) const {
    const double above = (1 - percent / 100) * static_cast<double>(count_);
    if (above < kSamplesAbove - 1e-6) return std::nullopt;
    return valueAt(percent);
}

std::vector<Histogram::Bucket> Histogram::buckets() const {
    std::vector<Bucket> result;
    for (std::uint32_t i = 0; i < counts_.size(); ++i)
        if (counts_[i] > 0) result.emplace_back(i, counts_[i]);
    return result;
}

void Histogram::add(const std::vector<Bucket>& buckets) {
    for (const auto& [index, times] : buckets) record(middleOf(index), times);
}

proto::Json Histogram::toJson() const {
    proto::Json counts = proto::Json::array();
    for (const auto& [index, times] : buckets()) counts.push_back({index, times});
    return {{"unit", "us"},
            {"significant_digits", 3},
            {"sub_buckets", kSubBuckets},
            {"count", count_},
            {"min", min()},
            {"max", max_},
            {"sum", sum_},
            {"counts", std::move(counts)}};
}

std::string Histogram::toHgrm() const {
    std::string text = "       Value     Percentile TotalCount 1/(1-Percentile)\n\n";
    char line[128];
    const auto append = [&](double percent, bool last) {
        const std::int64_t value = valueAt(percent);
        std::uint64_t total = 0;
        for (std::uint32_t i = 0; i <= indexOf(value) && i < counts_.size(); ++i)
            total += counts_[i];
        std::snprintf(line, sizeof line, "%12.3f %14.12f %10llu", static_cast<double>(value) / 1000,
                      percent / 100, static_cast<unsigned long long>(total));
        text += line;
        if (!last) {
            std::snprintf(line, sizeof line, " %14.2f", 100 / (100 - percent));
            text += line;
        }
        text += "\n";
    };
    // Five steps each time that the distance to 100 % is halved, until no sample is left above.
    double half = 100;
    while (count_ > 0 && half / 100 * static_cast<double>(count_) >= 1) {
        for (int step = 0; step < 5; ++step) append(100 - half + half * step / 10, false);
        half /= 2;
    }
    append(100, true);
    std::snprintf(line, sizeof line, "#[Mean    = %12.3f, StdDeviation   = %12.3f]\n",
                  mean() / 1000, deviation() / 1000);
    text += line;
    std::snprintf(line, sizeof line, "#[Max     = %12.3f, Total count    = %12llu]\n",
                  static_cast<double>(max_) / 1000, static_cast<unsigned long long>(count_));
    text += line;
    std::snprintf(line, sizeof line, "#[Buckets = %12u, SubBuckets     = %12d]\n",
                  indexOf(kHighest) / kHalf, kSubBuckets);
    return text + line;
}

core::Result<Histogram> readHistogram(const proto::Json& json) {
    const auto bad = [](const char* why) {
        return core::fail(core::ErrorCode::malformedRequest, why, "/histogram");
    };
    Histogram result;
    if (!json.is_object() || json.value("sub_buckets", 0) != Histogram::kSubBuckets ||
        !json.contains("counts") || !json["counts"].is_array())
        return bad("this is no histogram with 2048 sub-buckets");
    for (const proto::Json& pair : json["counts"]) {
        if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number_unsigned() ||
            !pair[1].is_number_unsigned() ||
            pair[0].get<std::uint64_t>() > Histogram::indexOf(Histogram::kHighest))
            return bad("each member of counts is a bucket and how often it was hit");
        result.record(middleOf(pair[0].get<std::uint32_t>()), pair[1].get<std::uint64_t>());
    }
    if (!json.contains("min") || !json.contains("max") || !json.contains("sum") ||
        !json["min"].is_number_integer() || !json["max"].is_number_integer() ||
        !json["sum"].is_number())
        return bad("min, max and sum are numbers");
    if (result.count_ == 0) return result;
    result.min_ = json["min"].get<std::int64_t>();
    result.max_ = json["max"].get<std::int64_t>();
    result.sum_ = json["sum"].get<double>();
    return result;
}

}  // namespace rivage::client::load
