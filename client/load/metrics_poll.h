#pragma once

#include <condition_variable>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "client/endpoint.h"

namespace rivage::client::load {

/// What the server said of itself at one moment.
using MetricsSample = std::map<std::string, double>;

/// Reads the lines of a Prometheus text that have no labels; of those with labels, the sum.
/// Only names that begin with "rivage_" or "process_", and no histograms.
[[nodiscard]] MetricsSample parseMetrics(std::string_view text);

/// Asks for /metrics each second, in a thread of its own.
class MetricsPoll {
public:
    explicit MetricsPoll(const ServerAccess& admin);
    ~MetricsPoll();
    MetricsPoll(const MetricsPoll&) = delete;
    MetricsPoll& operator=(const MetricsPoll&) = delete;
    /// Ends it. @return one sample a second; an empty one where the server did not answer
    std::vector<MetricsSample> stop();

private:
    void work();
    ServerAccess admin_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool stopping_ = false;
    std::vector<MetricsSample> samples_;
    std::thread thread_;
};

}  // namespace rivage::client::load
