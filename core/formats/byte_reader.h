#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace rivage::core {

/// Reads little-endian values from a span and never leaves it. The first read that does not fit
/// marks the reader as failed; from then on every read answers zero or empty, so that a caller
/// may read a whole record and ask `ok` once.
class ByteReader {
public:
    explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    [[nodiscard]] bool ok() const { return ok_; }
    [[nodiscard]] std::size_t offset() const { return offset_; }
    [[nodiscard]] std::size_t remaining() const { return bytes_.size() - offset_; }

    std::span<const std::byte> bytes(std::uint64_t count) {
        if (!ok_ || count > remaining()) {
            ok_ = false;
            return {};
        }
        const auto taken = bytes_.subspan(offset_, static_cast<std::size_t>(count));
        offset_ += static_cast<std::size_t>(count);
        return taken;
    }
    std::uint32_t u32() {
        std::uint32_t value = 0;
        const auto raw = bytes(4);
        for (std::size_t i = 0; i < raw.size(); ++i)
            value |= std::to_integer<std::uint32_t>(raw[i]) << (8 * i);
        return value;
    }
    std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
    /// A view into the bytes, so it lives as long as they do.
    std::string_view text(std::uint64_t count) {
        const auto raw = bytes(count);
        return {reinterpret_cast<const char*>(raw.data()), raw.size()};
    }

private:
    std::span<const std::byte> bytes_;
    std::size_t offset_ = 0;
    bool ok_ = true;
};

}  // namespace rivage::core
