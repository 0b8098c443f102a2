#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "proto/job.h"

namespace rivage::server {

/// How much the holder of a key may ask for.
struct QuotaLimits {
    std::uint32_t requests = 0;       ///< in each window; 0 is without limit
    std::chrono::seconds window{60};  ///< 1 s, 1 min or 1 h
    std::size_t jobs = 0;             ///< that have not ended; 0 is without limit
};

/// One line of the key file. The key itself is nowhere: only its sha-256 is.
struct ApiKey {
    std::string name;  ///< of who calls: 1 to 64 letters, digits, '.', '_' and '-'
    std::array<unsigned char, 32> hash{};
    QuotaLimits quota = {};
    std::optional<proto::WallTime> expires = {};  ///< the end of the day in the file, UTC
    bool disabled = false;

    [[nodiscard]] bool usable(proto::WallTime now) const {
        return !disabled && (!expires || now < *expires);
    }
};

/// All keys that the server knows; it never changes, a new file makes a new ring.
class KeyRing {
public:
    /// Reads lines `NAME sha256:HEX [rate=60/m] [jobs=4] [expires=2027-01-31] [disabled]`; what
    /// follows a '#' at the begin of a line or after a space is a comment.
    /// @errors invalidOption with the number of the line; the message never repeats a hash
    static core::Result<KeyRing> parse(std::string_view text);
    /// @errors as `parse`; also if the file cannot be read or has more than 4 MiB
    static core::Result<KeyRing> load(const std::string& path);

    /// The entry of a key that somebody presents. Takes the same time for every key of one length:
    /// all entries are compared, each with all bytes.
    /// @return null if there is none; usable or not
    [[nodiscard]] const ApiKey* find(std::string_view presented) const;

    [[nodiscard]] const std::vector<ApiKey>& keys() const { return keys_; }

private:
    std::vector<ApiKey> keys_;
};

/// The line of the key file for a key. @errors invalidOption if the key has less than 16 characters
/// or others than visible ASCII, or the name is none
core::Result<std::string> keyLine(const std::string& name, std::string_view key);

}  // namespace rivage::server
