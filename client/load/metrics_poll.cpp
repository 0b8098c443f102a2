#include "client/load/metrics_poll.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "client/interrupt.h"
#include "client/transport.h"

namespace rivage::client::load {
namespace {

/// Several times those of our server.
constexpr std::size_t kMostNames = 1000;

bool wanted(std::string_view name) {
    const bool ours = name.starts_with("rivage_") || name.starts_with("process_");
    // It becomes the head of a column: a server that sends something else is not quoted.
    const bool plain = name.size() <= 100 && std::all_of(name.begin(), name.end(), [](char c) {
                           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                                  (c >= '0' && c <= '9') || c == '_' || c == ':';
                       });
    return ours && plain && !name.ends_with("_bucket") && !name.ends_with("_sum") &&
           !name.ends_with("_count");
}

}  // namespace

MetricsSample parseMetrics(std::string_view text) {
    MetricsSample sample;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        const std::string_view name = line.substr(0, line.find_first_of("{ "));
        const std::size_t space = line.rfind(' ');
        if (line.starts_with('#') || space == std::string_view::npos || !wanted(name)) continue;
        const std::string_view number = line.substr(space + 1);
        double value = 0;
        const auto [stop, error] =
            std::from_chars(number.data(), number.data() + number.size(), value);
        if (error != std::errc() || !std::isfinite(value)) continue;
        if (sample.size() < kMostNames || sample.contains(std::string(name)))
            sample[std::string(name)] += value;
    }
    return sample;
}

MetricsPoll::MetricsPoll(const ServerAccess& admin) : admin_(admin), thread_([this] { work(); }) {}

MetricsPoll::~MetricsPoll() { stop(); }

void MetricsPoll::work() {
    Interrupt never;
    auto next = Clock::now();
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        lock.unlock();
        Transport transport(admin_, never, {.tries = 1});
        transport.setDeadline(Clock::now() + std::chrono::milliseconds(900));
        const auto answer = transport.send(makeRequest("GET", "/metrics"));
        MetricsSample sample;
        if (answer) sample = parseMetrics(answer->body);
        lock.lock();
        samples_.push_back(std::move(sample));
        next += std::chrono::seconds(1);
        changed_.wait_until(lock, next, [this] { return stopping_; });
    }
}

std::vector<MetricsSample> MetricsPoll::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        changed_.notify_one();
    }
    if (thread_.joinable()) thread_.join();
    return samples_;
}

}  // namespace rivage::client::load
