#pragma once

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

/// Reads GLB files for tests, by the text of the specification and without the writer's code.
/// Throws where a file breaks the container format or holds what is not expected.
namespace rivage::test {

struct ReadPrimitive {
    std::vector<std::array<float, 3>> positions;
    std::vector<std::array<float, 3>> normals;
    std::vector<std::array<std::uint16_t, 4>> colors;
    std::vector<std::uint32_t> indices;
    int material = -1;
};

struct ReadGlb {
    nlohmann::json json;
    std::vector<std::byte> buffer;

    [[nodiscard]] ReadPrimitive primitive(std::size_t mesh, std::size_t index) const;

private:
    [[nodiscard]] const std::byte* viewStart(const nlohmann::json& view) const {
        const std::size_t offset = view.value("byteOffset", std::size_t{0});
        if (offset % 4 != 0) throw std::runtime_error("view is not aligned");
        if (offset + view.at("byteLength").get<std::size_t>() > buffer.size())
            throw std::runtime_error("view exceeds the buffer");
        return buffer.data() + offset;
    }
    template <typename T>
    std::vector<T> plain(const nlohmann::json& accessorIndex) const {
        const auto& accessor = json.at("accessors").at(accessorIndex.get<std::size_t>());
        const auto& view = json.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
        std::vector<T> items(accessor.at("count").get<std::size_t>());
        if (items.size() * sizeof(T) != view.at("byteLength").get<std::size_t>())
            throw std::runtime_error("accessor and view differ in size");
        std::memcpy(items.data(), viewStart(view), items.size() * sizeof(T));
        return items;
    }
    void readPlain(const nlohmann::json& source, ReadPrimitive& out) const;
    void readDraco(const nlohmann::json& source, const nlohmann::json& extension,
                   ReadPrimitive& out) const;
};

inline ReadGlb readGlb(std::span<const std::byte> bytes) {
    const auto word = [&](std::size_t at) {
        std::uint32_t value = 0;
        if (at + 4 > bytes.size()) throw std::runtime_error("file ends early");
        std::memcpy(&value, bytes.data() + at, 4);
        return value;
    };
    if (word(0) != 0x46546C67 || word(4) != 2 || word(8) != bytes.size())
        throw std::runtime_error("bad header");
    if (word(16) != 0x4E4F534A || word(12) % 4 != 0) throw std::runtime_error("bad JSON chunk");
    const std::size_t binary = 20 + word(12);
    if (word(binary + 4) != 0x004E4942 || word(binary) % 4 != 0 ||
        binary + 8 + word(binary) != bytes.size())
        throw std::runtime_error("bad BIN chunk");
    ReadGlb glb;
    const auto* text = reinterpret_cast<const char*>(bytes.data()) + 20;
    glb.json = nlohmann::json::parse(text, text + word(12));
    glb.buffer.assign(bytes.begin() + static_cast<std::ptrdiff_t>(binary) + 8, bytes.end());
    return glb;
}

inline ReadPrimitive ReadGlb::primitive(std::size_t mesh, std::size_t index) const {
    const auto& source = json.at("meshes").at(mesh).at("primitives").at(index);
    ReadPrimitive out;
    out.material = source.at("material");
    const char* name = "KHR_draco_mesh_compression";
    if (source.contains("extensions") && source["extensions"].contains(name))
        readDraco(source, source["extensions"][name], out);
    else
        readPlain(source, out);
    return out;
}

inline void ReadGlb::readPlain(const nlohmann::json& source, ReadPrimitive& out) const {
    const auto& attributes = source.at("attributes");
    out.positions = plain<std::array<float, 3>>(attributes.at("POSITION"));
    if (attributes.contains("NORMAL"))
        out.normals = plain<std::array<float, 3>>(attributes["NORMAL"]);
    if (attributes.contains("COLOR_0"))
        out.colors = plain<std::array<std::uint16_t, 4>>(attributes["COLOR_0"]);
    const auto& accessor = json.at("accessors").at(source.at("indices").get<std::size_t>());
    if (accessor.at("componentType") == 5123) {
        const auto narrow = plain<std::uint16_t>(source["indices"]);
        out.indices.assign(narrow.begin(), narrow.end());
    } else {
        out.indices = plain<std::uint32_t>(source["indices"]);
    }
}

inline void ReadGlb::readDraco(const nlohmann::json& source, const nlohmann::json& extension,
                               ReadPrimitive& out) const {
    const auto& view = json.at("bufferViews").at(extension.at("bufferView").get<std::size_t>());
    draco::DecoderBuffer input;
    input.Init(reinterpret_cast<const char*>(viewStart(view)), view.at("byteLength"));
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&input);
    if (!decoded.ok()) throw std::runtime_error(decoded.status().error_msg_string());
    const draco::Mesh& mesh = *decoded.value();
    const auto read = [&]<typename T>(const char* name, std::vector<T>& items) {
        if (!source.at("attributes").contains(name)) return;
        const auto& accessor =
            json.at("accessors").at(source["attributes"][name].get<std::size_t>());
        if (accessor.at("count") != mesh.num_points() || accessor.contains("bufferView"))
            throw std::runtime_error("accessor does not match the stream");
        const auto* attribute =
            mesh.GetAttributeByUniqueId(extension.at("attributes").at(name).get<std::uint32_t>());
        for (draco::PointIndex v(0); v < mesh.num_points(); ++v) {
            T item;
            attribute->GetMappedValue(v, item.data());
            items.push_back(item);
        }
    };
    read("POSITION", out.positions);
    read("NORMAL", out.normals);
    read("COLOR_0", out.colors);
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
        for (int k = 0; k < 3; ++k) out.indices.push_back(mesh.face(f)[k].value());
    if (json.at("accessors").at(source.at("indices").get<std::size_t>()).at("count") !=
        out.indices.size())
        throw std::runtime_error("index count does not match the stream");
}

}  // namespace rivage::test
