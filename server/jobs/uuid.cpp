#include "server/jobs/uuid.h"

#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace rivage::server {

std::string UuidSource::next(std::chrono::system_clock::time_point now) {
    std::array<unsigned char, 16> bytes{};
    if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
        throw std::runtime_error("the system has no random numbers");
    {
        const std::lock_guard lock(mutex_);
        const auto ms =
            std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
        if (ms > lastMs_) {
            lastMs_ = ms;
            counter_ = bytes[6] & 0x7FU;  // starts low, so that a millisecond has room
        } else if (++counter_ > 0xFFF) {
            counter_ = 0;
            ++lastMs_;
        }
        for (int i = 0; i < 6; ++i) bytes[i] = static_cast<unsigned char>(lastMs_ >> (40 - 8 * i));
        bytes[6] = static_cast<unsigned char>(0x70 | counter_ >> 8);
        bytes[7] = static_cast<unsigned char>(counter_);
    }
    bytes[8] = static_cast<unsigned char>((bytes[8] & 0x3F) | 0x80);

    constexpr char kHex[] = "0123456789abcdef";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
        text += kHex[bytes[i] >> 4];
        text += kHex[bytes[i] & 15];
    }
    return text;
}

bool looksLikeUuid(const std::string& text) {
    if (text.size() != 36) return false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
        if (dash != (c == '-')) return false;
        if (!dash && !((c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'))) return false;
    }
    return true;
}

}  // namespace rivage::server
