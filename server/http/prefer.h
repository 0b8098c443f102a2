#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace rivage::server {

/// What a client prefers about waiting (RFC 7240). Preferences that are not understood count as
/// not given, as the RFC demands.
struct Prefer {
    bool respondAsync = false;
    std::optional<std::chrono::seconds> wait = {};  ///< at most one day

    /// The value of Preference-Applied; empty if nothing was preferred.
    [[nodiscard]] std::string applied() const;
};

[[nodiscard]] Prefer parsePrefer(const std::string& header);

}  // namespace rivage::server
