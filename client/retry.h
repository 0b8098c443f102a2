#pragma once

#include <chrono>
#include <cstdint>
#include <random>
#include <string>

namespace rivage::client {

/// How often and how long to try. The delay before try n is drawn from [0, base * 2^n), at most
/// `cap`, on top of what `Retry-After` asks for.
struct RetryPolicy {
    std::chrono::milliseconds base{250};
    std::chrono::milliseconds cap{10'000};
    int tries = 5;         ///< a full server is asked until the deadline, an absent one is not
    int patientTries = 9;  ///< with a job at the server there is more to lose: about 20 s
    /// Longer than the longest long poll, so that a server that says nothing is noticed.
    std::chrono::milliseconds silence{60'000};
};

/// What a Retry-After field asks for: whole seconds, or a date of HTTP; 0 if it is neither, or past.
[[nodiscard]] std::chrono::milliseconds retryAfter(const std::string& field,
                                                   std::chrono::system_clock::time_point now);

/// The random part of the pause before try n + 1, n >= 1.
[[nodiscard]] std::chrono::milliseconds jitter(const RetryPolicy& policy, int n,
                                               std::mt19937_64& random);

}  // namespace rivage::client
