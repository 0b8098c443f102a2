#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Builds .vox files byte by byte for tests, right or wrong as wanted; shares nothing with the
/// project's own writer.
namespace rivage::test {

class VoxBuilder {
public:
    using Dict = std::vector<std::pair<std::string, std::string>>;
    struct Voxel {
        int x, y, z, color;
    };

    explicit VoxBuilder(int version = 200) : version_(version) {}

    VoxBuilder& chunk(std::string_view id, const std::string& content) {
        children_ += std::string(id) + number(static_cast<std::uint32_t>(content.size())) +
                     number(0) + content;
        return *this;
    }
    VoxBuilder& size(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
        return chunk("SIZE", number(x) + number(y) + number(z));
    }
    VoxBuilder& voxels(const std::vector<Voxel>& voxels) {
        std::string content = number(static_cast<std::uint32_t>(voxels.size()));
        for (const Voxel& v : voxels)
            for (const int byte : {v.x, v.y, v.z, v.color}) content += static_cast<char>(byte);
        return chunk("XYZI", content);
    }
    /// A model with one voxel of this colour in a corner of a cube.
    VoxBuilder& cube(int side, int color) {
        const auto s = static_cast<std::uint32_t>(side);
        return size(s, s, s).voxels({{0, 0, 0, color}});
    }
    VoxBuilder& transform(std::uint32_t id, std::uint32_t child, const Dict& frame = {},
                          const Dict& attributes = {}, int layer = -1) {
        return chunk("nTRN", number(id) + dict(attributes) + number(child) + number(0xffffffff) +
                                 number(static_cast<std::uint32_t>(layer)) + number(1) +
                                 dict(frame));
    }
    VoxBuilder& group(std::uint32_t id, const std::vector<std::uint32_t>& children,
                      const Dict& attributes = {}) {
        std::string content =
            number(id) + dict(attributes) + number(static_cast<std::uint32_t>(children.size()));
        for (const std::uint32_t child : children) content += number(child);
        return chunk("nGRP", content);
    }
    VoxBuilder& shape(std::uint32_t id, const std::vector<std::uint32_t>& models,
                      const Dict& attributes = {}) {
        std::string content =
            number(id) + dict(attributes) + number(static_cast<std::uint32_t>(models.size()));
        for (const std::uint32_t model : models) content += number(model) + dict({});
        return chunk("nSHP", content);
    }
    VoxBuilder& layer(std::uint32_t id, const Dict& attributes) {
        return chunk("LAYR", number(id) + dict(attributes) + number(0xffffffff));
    }
    VoxBuilder& material(std::uint32_t id, const Dict& properties) {
        return chunk("MATL", number(id) + dict(properties));
    }
    /// Entry i (0-based) of the palette is (i, 255 - i, 7, 255).
    VoxBuilder& palette() {
        std::string content;
        for (int i = 0; i < 256; ++i)
            for (const int byte : {i, 255 - i, 7, 255}) content += static_cast<char>(byte);
        return chunk("RGBA", content);
    }

    [[nodiscard]] std::vector<std::byte> bytes() const {
        return toBytes("VOX " + number(static_cast<std::uint32_t>(version_)) + "MAIN" + number(0) +
                       number(static_cast<std::uint32_t>(children_.size())) + children_);
    }

    static std::string number(std::uint32_t value) {
        std::string text;
        for (int i = 0; i < 4; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
        return text;
    }
    static std::string string(std::string_view value) {
        return number(static_cast<std::uint32_t>(value.size())) + std::string(value);
    }
    static std::string dict(const Dict& pairs) {
        std::string text = number(static_cast<std::uint32_t>(pairs.size()));
        for (const auto& [key, value] : pairs) text += string(key) + string(value);
        return text;
    }
    static std::vector<std::byte> toBytes(std::string_view text) {
        std::vector<std::byte> bytes;
        for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
        return bytes;
    }

private:
    int version_;
    std::string children_;
};

/// Two models under a scene graph with a layer, a material, a palette and a name: every chunk that
/// the reader knows, in 1.9 kB.
inline std::vector<std::byte> smallVox() {
    std::string order;
    for (int i = 0; i < 256; ++i) order += static_cast<char>(255 - i);
    std::string legacy = VoxBuilder::number(7) + VoxBuilder::number(1) +
                         VoxBuilder::number(0x3f000000) + VoxBuilder::number(2) +
                         VoxBuilder::number(0x3e800000);
    return VoxBuilder(200)
        .chunk("PACK", VoxBuilder::number(2))
        .size(2, 3, 1)
        .voxels({{0, 0, 0, 1}, {1, 2, 0, 2}})
        .cube(3, 7)
        .transform(0, 1)
        .group(1, {2, 4})
        .transform(2, 3, {{"_t", "4 -1 2"}, {"_r", "4"}}, {{"_name", "left"}}, 0)
        .shape(3, {0})
        .transform(4, 5, {{"_t", "0 0 0"}}, {{"_hidden", "1"}})
        .shape(5, {1})
        .layer(0, {{"_name", "ground"}})
        .palette()
        .chunk("IMAP", order)
        .material(2, {{"_type", "_glass"}, {"_ri", "1.4"}, {"_trans", "0.5"}})
        .chunk("MATT", legacy)
        .chunk("NOTE", VoxBuilder::number(1) + VoxBuilder::string("row"))
        .bytes();
}

}  // namespace rivage::test
