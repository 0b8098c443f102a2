#include "client/compare/glb_primitive.h"

#include <utility>

namespace rivage::client {
namespace {

using proto::Json;

constexpr int kFloat = 5126;
constexpr int kTriangles = 4;

const char* const kDraco = "KHR_draco_mesh_compression";

tl::unexpected<Failure> tooLarge() {
    return unsupported("it has more triangles or vertices than are read here");
}

/// The counts that the accessors of a Draco primitive announce.
Outcome<GlbPrimitive> readDraco(const GlbDocument& document, const Json& primitive,
                                const GlbRoom& room) {
    const Json& extension = memberOf(memberOf(primitive, "extensions"), kDraco);
    const auto stream = document.bufferView(memberOf(extension, "bufferView"));
    if (!stream) return tl::unexpected(stream.error());
    const auto indices = document.element("accessors", memberOf(primitive, "indices"));
    if (!indices) return tl::unexpected(indices.error());
    const Json& position = memberOf(memberOf(primitive, "attributes"), "POSITION");
    const auto positions = document.element("accessors", position);
    if (!positions) return tl::unexpected(positions.error());
    const auto corners = wholeOf(memberOf(**indices, "count"));
    const auto vertices = wholeOf(memberOf(**positions, "count"));
    if (!corners || !vertices || *corners == 0 || *corners % 3 != 0)
        return malformed("the accessors of a Draco primitive make no sense");
    if (*corners / 3 > room.triangles || *vertices > room.vertices) return tooLarge();
    return decodeDraco(*stream, *corners / 3, *vertices, memberOf(extension, "attributes"));
}

Outcome<std::vector<Eigen::Vector3f>> readRows(const AccessorData& data) {
    if (data.components < 3) return malformed("a position or colour has three components");
    std::vector<Eigen::Vector3f> rows;
    rows.reserve(data.count);
    for (std::size_t i = 0; i < data.count; ++i)
        rows.emplace_back(data.number(i, 0), data.number(i, 1), data.number(i, 2));
    return rows;
}

Outcome<void> readIndices(const GlbDocument& document, const Json& index, const GlbRoom& room,
                          GlbPrimitive& out) {
    std::size_t corners = out.positions.size();
    AccessorData data;
    if (!index.is_null()) {
        auto read = document.accessor(index);
        if (!read) return tl::unexpected(read.error());
        data = *read;
        const bool whole =
            data.componentType == 5121 || data.componentType == 5123 || data.componentType == 5125;
        if (!whole || data.components != 1) return malformed("indices are whole numbers");
        corners = data.count;
        out.bytes["indices"] = data.bytes();
    }
    if (corners % 3 != 0) return malformed("the indices are not those of triangles");
    if (corners / 3 > room.triangles) return tooLarge();
    out.triangles.resize(corners / 3);
    for (std::size_t i = 0; i < corners; ++i) {
        const auto vertex = data.first == nullptr ? static_cast<std::uint32_t>(i) : data.index(i);
        if (vertex >= out.positions.size()) return malformed("an index names no vertex");
        out.triangles[i / 3][i % 3] = vertex;
    }
    return {};
}

Outcome<GlbPrimitive> readPlain(const GlbDocument& document, const Json& primitive,
                                const GlbRoom& room) {
    GlbPrimitive out;
    const Json& attributes = memberOf(primitive, "attributes");
    for (const auto& [name, index] : attributes.items()) {
        auto data = document.accessor(index);
        if (!data) return tl::unexpected(data.error());
        out.bytes[name] = data->bytes();
        if (name != "POSITION" && name != "COLOR_0") continue;
        if (data->count > room.vertices) return tooLarge();
        if (name == "COLOR_0" && data->componentType != kFloat) data->normalized = true;
        auto rows = readRows(*data);
        if (!rows) return tl::unexpected(rows.error());
        (name == "POSITION" ? out.positions : out.colors) = std::move(*rows);
    }
    if (!out.colors.empty() && out.colors.size() != out.positions.size())
        return malformed("there are not as many colours as positions");
    if (auto read = readIndices(document, memberOf(primitive, "indices"), room, out); !read)
        return tl::unexpected(read.error());
    return out;
}

}  // namespace

Outcome<GlbPrimitive> readPrimitive(const GlbDocument& document, const Json& primitive,
                                    const GlbRoom& room) {
    if (!memberOf(primitive, "attributes").is_object())
        return malformed("a primitive has no attributes");
    if (wholeOf(primitive, "mode", kTriangles) != kTriangles)
        return unsupported("it has primitives that are not triangles");
    if (!memberOf(memberOf(primitive, "extensions"), kDraco).is_null())
        return readDraco(document, primitive, room);
    return readPlain(document, primitive, room);
}

}  // namespace rivage::client
