#include "server/keys/quota.h"

#include <algorithm>
#include <cmath>

namespace rivage::server {

Charge QuotaBook::take(const std::string& name, const QuotaLimits& limits) {
    if (limits.requests == 0) return {};
    const double capacity = limits.requests;
    const double perSecond = capacity / static_cast<double>(limits.window.count());
    const auto now = now_();
    const std::lock_guard lock(mutex_);
    Bucket& bucket = buckets_.try_emplace(name, Bucket{capacity, now}).first->second;
    const double passed = std::chrono::duration<double>(now - bucket.filled).count();
    bucket.tokens = std::min(capacity, bucket.tokens + std::max(0.0, passed) * perSecond);
    bucket.filled = now;
    if (bucket.tokens >= 1) {
        bucket.tokens -= 1;
        return {};
    }
    const double wait = std::ceil((1 - bucket.tokens) / perSecond);
    return {false, std::chrono::seconds(std::max(1L, static_cast<long>(wait)))};
}

void QuotaBook::keepOnly(const KeyRing& ring) {
    const auto known = [&ring](const std::string& name) {
        return std::any_of(ring.keys().begin(), ring.keys().end(),
                           [&name](const ApiKey& key) { return key.name == name; });
    };
    const std::lock_guard lock(mutex_);
    std::erase_if(buckets_, [&known](const auto& entry) { return !known(entry.first); });
}

std::size_t QuotaBook::size() const {
    const std::lock_guard lock(mutex_);
    return buckets_.size();
}

}  // namespace rivage::server
