#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace rivage::server {

/// Makes version 7 UUIDs: they sort by the time at which they were made, and nobody can guess one
/// from another. Safe to call from several threads.
/// @source RFC 9562, section 5.7 and method 1 of section 6.2
class UuidSource {
public:
    [[nodiscard]] std::string next(std::chrono::system_clock::time_point now);

private:
    std::mutex mutex_;
    std::int64_t lastMs_ = 0;
    std::uint32_t counter_ = 0;  ///< 12 bits, orders the ids of one millisecond
};

/// Whether a text has the form of a lower-case UUID.
[[nodiscard]] bool looksLikeUuid(const std::string& text);

}  // namespace rivage::server
