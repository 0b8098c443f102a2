#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rivage::core {

/// Collects the little-endian content of one RIFF-like chunk.
class ChunkWriter {
public:
    ChunkWriter& u32(std::uint32_t value) {
        for (int i = 0; i < 4; ++i) bytes_.push_back(static_cast<std::byte>(value >> (8 * i)));
        return *this;
    }
    ChunkWriter& i32(std::int32_t value) { return u32(static_cast<std::uint32_t>(value)); }
    ChunkWriter& u8(std::uint32_t value) {
        bytes_.push_back(static_cast<std::byte>(value));
        return *this;
    }
    ChunkWriter& raw(std::string_view text) {
        for (const char c : text) bytes_.push_back(static_cast<std::byte>(c));
        return *this;
    }
    ChunkWriter& string(std::string_view text) {
        return u32(static_cast<std::uint32_t>(text.size())).raw(text);
    }
    ChunkWriter& dict(const std::vector<std::pair<std::string, std::string>>& pairs) {
        u32(static_cast<std::uint32_t>(pairs.size()));
        for (const auto& [key, value] : pairs) string(key).string(value);
        return *this;
    }
    /// Appends a whole chunk without children: id, sizes, content.
    ChunkWriter& chunk(std::string_view id, const ChunkWriter& content) {
        raw(id).u32(static_cast<std::uint32_t>(content.bytes_.size())).u32(0);
        bytes_.insert(bytes_.end(), content.bytes_.begin(), content.bytes_.end());
        return *this;
    }
    [[nodiscard]] std::size_t size() const { return bytes_.size(); }
    [[nodiscard]] std::vector<std::byte> take() && { return std::move(bytes_); }

private:
    std::vector<std::byte> bytes_;
};

}  // namespace rivage::core
