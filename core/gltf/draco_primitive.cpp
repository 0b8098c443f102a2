#include "core/gltf/draco_primitive.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <string>

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

namespace rivage::core {
namespace {

constexpr int kNormalBits = 10;  // octahedral: 0.1 degrees

tl::unexpected<Error> broken(const std::string& what) {
    return fail(ErrorCode::internal, "the mesh cannot be compressed: " + what);
}

// One value a surface point, which all its vertices share.
int addPositions(const MeshPrimitive& primitive, const Placement& placement, draco::Mesh& mesh) {
    const std::uint32_t top = *std::max_element(primitive.points.begin(), primitive.points.end());
    constexpr std::uint32_t kUnseen = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> valueOf(std::size_t{top} + 1, kUnseen);
    std::uint32_t values = 0;
    for (const std::uint32_t point : primitive.points)
        if (valueOf[point] == kUnseen) valueOf[point] = values++;

    draco::GeometryAttribute layout;
    layout.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                3 * sizeof(float), 0);
    const int id = mesh.AddAttribute(layout, false, values);
    draco::PointAttribute& attribute = *mesh.attribute(id);
    for (std::uint32_t v = 0; v < primitive.points.size(); ++v) {
        const draco::AttributeValueIndex value(valueOf[primitive.points[v]]);
        const Vec3f position = placement.position(primitive.positions[v]);
        attribute.SetAttributeValue(value, position.data());
        attribute.SetPointMapEntry(draco::PointIndex(v), value);
    }
    return id;
}

int addNormals(const MeshPrimitive& primitive, const Placement& placement, draco::Mesh& mesh) {
    draco::GeometryAttribute layout;
    layout.Init(draco::GeometryAttribute::NORMAL, nullptr, 3, draco::DT_FLOAT32, false,
                3 * sizeof(float), 0);
    const auto count = static_cast<std::uint32_t>(primitive.normals.size());
    const int id = mesh.AddAttribute(layout, true, count);
    draco::PointAttribute& attribute = *mesh.attribute(id);
    for (std::uint32_t v = 0; v < count; ++v) {
        const Vec3f normal = placement.direction(primitive.normals[v].cast<double>()).cast<float>();
        attribute.SetAttributeValue(draco::AttributeValueIndex(v), normal.data());
    }
    attribute.DeduplicateValues(attribute);
    return id;
}

int addColors(const MeshPrimitive& primitive, draco::Mesh& mesh) {
    draco::GeometryAttribute layout;
    layout.Init(draco::GeometryAttribute::COLOR, nullptr, 4, draco::DT_UINT16, true,
                4 * sizeof(std::uint16_t), 0);
    const auto count = static_cast<std::uint32_t>(primitive.colors.size());
    const int id = mesh.AddAttribute(layout, true, count);
    draco::PointAttribute& attribute = *mesh.attribute(id);
    for (std::uint32_t v = 0; v < count; ++v)
        attribute.SetAttributeValue(draco::AttributeValueIndex(v), primitive.colors[v].data());
    attribute.DeduplicateValues(attribute);
    return id;
}

void addTriangles(const MeshPrimitive& primitive, draco::Mesh& mesh) {
    mesh.SetNumFaces(2 * primitive.quads.size());
    std::uint32_t next = 0;
    for (const Quad& quad : primitive.quads) {
        const std::array<draco::PointIndex, 4> v = {
            draco::PointIndex(quad[0]), draco::PointIndex(quad[1]), draco::PointIndex(quad[2]),
            draco::PointIndex(quad[3])};
        mesh.SetFace(draco::FaceIndex(next++), {v[0], v[1], v[2]});
        mesh.SetFace(draco::FaceIndex(next++), {v[0], v[2], v[3]});
    }
}

struct Bounds {
    Vec3f low = Vec3f::Constant(std::numeric_limits<float>::infinity());
    Vec3f high = -low;
    void add(const Vec3f& position) {
        low = low.cwiseMin(position);
        high = high.cwiseMax(position);
    }
};

// Reads the stream back, sets the true figures and compares them with the source.
Result<void> decodeAndCheck(const MeshPrimitive& primitive, const Placement& placement,
                            const Quantization& grid, DracoPrimitive& out) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(out.bytes.data()), out.bytes.size());
    draco::Decoder decoder;
    const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) return broken(decoded.status().error_msg_string());
    const draco::Mesh& mesh = *decoded.value();
    const draco::PointAttribute* positions = mesh.GetAttributeByUniqueId(out.positionId);
    out.vertices = mesh.num_points();
    out.triangles = mesh.num_faces();
    if (positions == nullptr || out.triangles != 2 * primitive.quads.size())
        return broken("the stream does not decode to the same triangles");

    Bounds after;
    for (draco::PointIndex v(0); v < mesh.num_points(); ++v) {
        Vec3f position;
        positions->GetMappedValue(v, position.data());
        after.add(position);
    }
    Bounds before;
    for (const Vec3d& position : primitive.positions) before.add(placement.position(position));
    const double gap = std::max((after.low - before.low).cwiseAbs().maxCoeff(),
                                (after.high - before.high).cwiseAbs().maxCoeff());
    if (!(gap <= grid.step())) return broken("the stream does not decode to the same bounds");
    for (int i = 0; i < 3; ++i) {
        out.low[i] = after.low[i];
        out.high[i] = after.high[i];
    }
    return {};
}

Result<DracoPrimitive> encode(const MeshPrimitive& primitive, const Placement& placement,
                              const Quantization& grid, int speed) {
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<std::uint32_t>(primitive.positions.size()));
    addTriangles(primitive, mesh);
    DracoPrimitive out;
    out.positionId = mesh.attribute(addPositions(primitive, placement, mesh))->unique_id();
    if (!primitive.normals.empty())
        out.normalId = mesh.attribute(addNormals(primitive, placement, mesh))->unique_id();
    if (!primitive.colors.empty())
        out.colorId = mesh.attribute(addColors(primitive, mesh))->unique_id();

    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetAttributeExplicitQuantization(draco::GeometryAttribute::POSITION, grid.bits, 3,
                                             grid.origin.data(), grid.range);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, kNormalBits);
    draco::EncoderBuffer buffer;
    const draco::Status status = encoder.EncodeMeshToBuffer(mesh, &buffer);
    if (!status.ok()) return broken(status.error_msg_string());
    const auto* first = reinterpret_cast<const std::byte*>(buffer.data());
    out.bytes.assign(first, first + buffer.size());
    if (auto checked = decodeAndCheck(primitive, placement, grid, out); !checked)
        return fail(std::move(checked.error()));
    return out;
}

}  // namespace

Result<DracoPrimitive> encodeDraco(const MeshPrimitive& primitive, const Placement& placement,
                                   const Quantization& grid, int speed) {
    assert(!primitive.quads.empty());
    try {
        return encode(primitive, placement, grid, speed);
    } catch (const std::exception& exception) {
        return broken(exception.what());
    }
}

}  // namespace rivage::core
