#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "server/keys/api_keys.h"

namespace rivage::server {

/// What a request was told about its quota.
struct Charge {
    bool granted = true;
    std::chrono::seconds retryAfter{0};  ///< when the next request is granted, rounded up
};

/// One token bucket for each caller: full it holds one window's requests, and it fills up evenly.
/// Holds as many buckets as there are keys. Safe to use from several threads.
class QuotaBook {
public:
    using Now = std::function<std::chrono::steady_clock::time_point()>;
    explicit QuotaBook(Now now = std::chrono::steady_clock::now) : now_(std::move(now)) {}

    /// Takes one request out of the caller's bucket, if there is one in it.
    Charge take(const std::string& name, const QuotaLimits& limits);
    /// Forgets the callers that have no key any more.
    void keepOnly(const KeyRing& ring);
    [[nodiscard]] std::size_t size() const;

private:
    struct Bucket {
        double tokens;
        std::chrono::steady_clock::time_point filled;
    };
    const Now now_;
    mutable std::mutex mutex_;
    std::map<std::string, Bucket> buckets_;
};

}  // namespace rivage::server
