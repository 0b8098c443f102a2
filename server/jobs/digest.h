#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace rivage::server {

/// The sha-256 of some bytes, in the two forms in which HTTP carries it.
struct Digest {
    std::string hex;
    std::string base64;
};
[[nodiscard]] Digest sha256(std::span<const std::byte> bytes);

/// The digest whose hexadecimal form this is; empty if it is none.
[[nodiscard]] Digest digestOf(const std::string& hex);

}  // namespace rivage::server
