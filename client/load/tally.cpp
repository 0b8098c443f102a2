#include "client/load/tally.h"

#include <algorithm>

namespace rivage::client::load {

const char* nameOf(Measure measure) {
    switch (measure) {
        case Measure::corrected: return "corrected";
        case Measure::asSent: return "as_sent";
        case Measure::service: return "service";
        case Measure::lag: return "send_lag";
        case Measure::refused: return "refused";
        case Measure::connect: return "connect";
        case Measure::tls: return "tls";
        case Measure::upload: return "upload";
        case Measure::wait: return "wait";
        case Measure::download: return "download";
        case Measure::serverQueue: return "server_queue";
        case Measure::serverCompute: return "server_compute";
        case Measure::serverOverhead: return "server_overhead";
        case Measure::jobResult: return "job_result";
        case Measure::jobFirstEvent: return "job_first_event";
        case Measure::jobCancel: return "job_cancel";
        case Measure::slow: return "slow_clients";
    }
    return "";
}

std::vector<Measure> allMeasures() {
    std::vector<Measure> all;
    for (std::size_t i = 0; i < kMeasures; ++i) all.push_back(static_cast<Measure>(i));
    return all;
}

void Tally::merge(const Tally& other) {
    for (std::uint64_t Tally::*member :
         {&Tally::planned, &Tally::sent, &Tally::good, &Tally::withinSlo, &Tally::refused,
          &Tally::failed, &Tally::aborted, &Tally::abandoned, &Tally::cancelled, &Tally::slow,
          &Tally::late, &Tally::retried, &Tally::jobs, &Tally::polls})
        this->*member += other.*member;
    for (std::size_t i = 0; i < kMeasures; ++i) times[i].merge(other.times[i]);
    for (const auto& [name, count] : other.errors) errors[name] += count;
    for (const auto& [status, count] : other.statuses) statuses[status] += count;
    if (entries.size() < other.entries.size()) entries.resize(other.entries.size());
    for (std::size_t i = 0; i < other.entries.size(); ++i) {
        entries[i].planned += other.entries[i].planned;
        entries[i].good += other.entries[i].good;
        entries[i].corrected.merge(other.entries[i].corrected);
    }
}

std::uint64_t Tally::notSent() const {
    const auto found = errors.find("not-sent");
    return found == errors.end() ? 0 : found->second;
}

double Tally::errorRate() const {
    return judged() == 0 ? 0
                         : static_cast<double>(refused + failed) / static_cast<double>(judged());
}

void Second::merge(const Second& other) {
    for (std::uint64_t Second::*member : {&Second::sent, &Second::good, &Second::withinSlo,
                                          &Second::refused, &Second::failed, &Second::bytesIn})
        this->*member += other.*member;
    corrected.insert(corrected.end(), other.corrected.begin(), other.corrected.end());
    asSent.insert(asSent.end(), other.asSent.begin(), other.asSent.end());
}

Histogram Second::latency() const {
    Histogram histogram;
    histogram.add(corrected);
    return histogram;
}

void Series::add(std::size_t second, const Second& part) {
    const std::lock_guard lock(mutex_);
    if (seconds_.size() <= second) seconds_.resize(second + 1);
    seconds_[second].merge(part);
}

std::vector<Second> Series::all() const {
    const std::lock_guard lock(mutex_);
    return seconds_;
}

std::size_t Series::size() const {
    const std::lock_guard lock(mutex_);
    return seconds_.size();
}

Second Series::between(std::size_t begin, std::size_t end) const {
    const std::lock_guard lock(mutex_);
    Second sum;
    for (std::size_t i = begin; i < std::min(end, seconds_.size()); ++i) sum.merge(seconds_[i]);
    return sum;
}

}  // namespace rivage::client::load
