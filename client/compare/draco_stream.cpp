#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

#include <utility>

#include "client/compare/glb_primitive.h"

namespace rivage::client {
namespace {

using proto::Json;

constexpr std::uint16_t kVersion = 0x0202;  // 2.2, which the glTF extension prescribes
constexpr unsigned char kTriangularMesh = 1;
constexpr unsigned char kEdgebreaker = 1;
constexpr std::size_t kHeaderBytes = 11;
constexpr std::uint16_t kHasMetadata = 0x8000;

// libdraco makes room for as many triangles as a stream announces. Ours have about one to two bytes
// a triangle; a stream with a hundred times more of them is not one of a surface.
constexpr std::uint64_t kTrianglesPerByte = 64;
constexpr std::uint64_t kFreeTriangles = 1000;

/// A number of seven bits a byte, lowest first.
bool takeVarint(std::string_view& rest, std::uint64_t& value) {
    value = 0;
    for (int shift = 0; shift < 35 && !rest.empty(); shift += 7) {
        const auto byte = static_cast<unsigned char>(rest.front());
        rest.remove_prefix(1);
        value |= std::uint64_t{byte & 0x7FU} << shift;
        if ((byte & 0x80U) == 0) return true;
    }
    return false;
}

/// Reads what the head of a stream announces, so that nothing is decoded that asks for more memory
/// than its size explains.
Outcome<void> checkHead(std::string_view stream, std::size_t triangles, std::size_t vertices) {
    const auto byteAt = [&](std::size_t i) { return static_cast<unsigned char>(stream[i]); };
    if (stream.size() < kHeaderBytes || !stream.starts_with("DRACO"))
        return malformed("a Draco stream has no header");
    if (byteAt(5) != kVersion >> 8 || byteAt(6) != (kVersion & 0xFF))
        return unsupported("its Draco streams are not of version 2.2");
    if (byteAt(7) != kTriangularMesh) return malformed("a Draco stream holds no mesh");
    if (((byteAt(9) | byteAt(10) << 8) & kHasMetadata) != 0)
        return unsupported("its Draco streams have metadata");
    const bool edgebreaker = byteAt(8) == kEdgebreaker;
    std::string_view rest = stream.substr(kHeaderBytes);
    if (edgebreaker && !rest.empty()) rest.remove_prefix(1);  // how it walks the mesh
    std::uint64_t first = 0;
    std::uint64_t second = 0;
    if (!takeVarint(rest, first) || !takeVarint(rest, second))
        return malformed("a Draco stream is cut");
    const std::uint64_t faces = edgebreaker ? second : first;
    const std::uint64_t points = edgebreaker ? first : second;
    if (faces > triangles || points > vertices || vertices > 3 * std::uint64_t{triangles})
        return malformed("a Draco stream has other counts than its accessors");
    if (faces > kFreeTriangles + kTrianglesPerByte * stream.size())
        return malformed("a Draco stream announces more triangles than it can hold");
    return {};
}

/// The rows of three numbers of an attribute, one a point.
Outcome<std::vector<Eigen::Vector3f>> rowsOf(const draco::Mesh& mesh, const Json& id) {
    const auto number = wholeOf(id);
    const draco::PointAttribute* attribute =
        number && *number < UINT32_MAX
            ? mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(*number))
            : nullptr;
    if (attribute == nullptr || attribute->num_components() < 3)
        return malformed("a Draco stream lacks an attribute that the primitive names");
    std::vector<Eigen::Vector3f> rows(mesh.num_points());
    for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
        const draco::AttributeValueIndex value = attribute->mapped_index(point);
        if (value.value() >= attribute->size() ||
            !attribute->ConvertValue<float>(value, 3, rows[point.value()].data()))
            return malformed("a Draco stream has an attribute that is cut");
    }
    return rows;
}

Outcome<GlbPrimitive> convert(const draco::Mesh& mesh, const Json& ids) {
    GlbPrimitive out;
    auto positions = rowsOf(mesh, memberOf(ids, "POSITION"));
    if (!positions) return tl::unexpected(positions.error());
    out.positions = std::move(*positions);
    if (const Json& id = memberOf(ids, "COLOR_0"); !id.is_null()) {
        auto colors = rowsOf(mesh, id);
        if (!colors) return tl::unexpected(colors.error());
        out.colors = std::move(*colors);
    }
    out.triangles.resize(mesh.num_faces());
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t vertex = mesh.face(f)[i].value();
            if (vertex >= out.positions.size()) return malformed("an index names no vertex");
            out.triangles[f.value()][i] = vertex;
        }
    return out;
}

}  // namespace

Outcome<GlbPrimitive> decodeDraco(std::string_view stream, std::size_t triangles,
                                  std::size_t vertices, const Json& ids) {
    if (auto head = checkHead(stream, triangles, vertices); !head)
        return tl::unexpected(head.error());
    draco::DecoderBuffer buffer;
    buffer.Init(stream.data(), stream.size());
    draco::Decoder decoder;
    const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok())
        return malformed(std::string("a Draco stream does not decode: ") +
                         decoded.status().error_msg_string());
    const draco::Mesh& mesh = *decoded.value();
    if (mesh.num_faces() != triangles || mesh.num_points() != vertices)
        return malformed("a Draco stream has other counts than its accessors");
    auto out = convert(mesh, ids);
    if (out) out->bytes["draco"] = stream.size();
    return out;
}

}  // namespace rivage::client
