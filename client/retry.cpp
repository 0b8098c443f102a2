#include "client/retry.h"

#include <algorithm>
#include <charconv>
#include <ctime>

namespace rivage::client {

using std::chrono::milliseconds;

milliseconds retryAfter(const std::string& field, std::chrono::system_clock::time_point now) {
    int seconds = 0;
    const char* const end = field.data() + field.size();
    const auto [rest, error] = std::from_chars(field.data(), end, seconds);
    if (error == std::errc() && rest == end && seconds >= 0)
        return milliseconds(std::int64_t{1000} * seconds);
    std::tm date{};
    const char* const read = ::strptime(field.c_str(), "%a, %d %b %Y %H:%M:%S GMT", &date);
    if (read == nullptr || *read != '\0') return milliseconds(0);
    const auto until = std::chrono::system_clock::from_time_t(::timegm(&date));
    return std::max(std::chrono::duration_cast<milliseconds>(until - now), milliseconds(0));
}

milliseconds jitter(const RetryPolicy& policy, int n, std::mt19937_64& random) {
    const auto doubled = policy.base.count() << std::min(n, 16);
    const auto most = std::min<std::int64_t>(doubled, policy.cap.count());
    std::uniform_int_distribution<std::int64_t> draw(0, std::max<std::int64_t>(most, 1));
    return milliseconds(draw(random));
}

}  // namespace rivage::client
