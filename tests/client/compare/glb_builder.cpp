#include "glb_builder.h"

#include <doctest/doctest.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <cmath>
#include <cstring>

namespace rivage::client::test {
namespace {

using Eigen::Vector3f;
using proto::Json;

constexpr double kPi = 3.14159265358979323846;

void addQuad(Shape& shape, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    shape.triangles.push_back({a, b, c});
    shape.triangles.push_back({a, c, d});
}

template <typename T>
int addView(GlbSource& glb, const std::vector<T>& values) {
    glb.binary.resize((glb.binary.size() + 3) / 4 * 4);
    const std::size_t bytes = values.size() * sizeof(T);
    glb.json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", glb.binary.size()}, {"byteLength", bytes}});
    glb.binary.append(reinterpret_cast<const char*>(values.data()), bytes);
    return static_cast<int>(glb.json["bufferViews"].size()) - 1;
}

int addAccessor(GlbSource& glb, int view, int componentType, const char* type, std::size_t count) {
    Json accessor = {{"componentType", componentType}, {"type", type}, {"count", count}};
    if (view >= 0) accessor["bufferView"] = view;
    glb.json["accessors"].push_back(std::move(accessor));
    return static_cast<int>(glb.json["accessors"].size()) - 1;
}

std::string dracoStream(const Shape& shape, int bits, std::size_t& points) {
    draco::Mesh mesh;
    const auto count = static_cast<std::uint32_t>(shape.positions.size());
    mesh.set_num_points(count);
    mesh.SetNumFaces(shape.triangles.size());
    for (std::uint32_t f = 0; f < shape.triangles.size(); ++f) {
        const auto& t = shape.triangles[f];
        mesh.SetFace(draco::FaceIndex(f),
                     {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
    }
    draco::GeometryAttribute layout;
    layout.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                3 * sizeof(float), 0);
    const int id = mesh.AddAttribute(layout, true, count);
    for (std::uint32_t v = 0; v < count; ++v)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v),
                                              shape.positions[v].data());
    draco::Encoder encoder;
    encoder.SetSpeedOptions(5, 5);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
    encoder.SetTrackEncodedProperties(true);
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) throw std::runtime_error("draco");
    points = encoder.num_encoded_points();
    return {buffer.data(), buffer.size()};
}

void addNode(GlbSource& glb, Json primitive) {
    const std::size_t number = glb.json["nodes"].size();
    glb.json["meshes"].push_back({{"primitives", Json::array({std::move(primitive)})}});
    glb.json["nodes"].push_back({{"mesh", number}, {"name", "part " + std::to_string(number + 1)}});
    glb.json["scenes"][0]["nodes"].push_back(number);
    glb.json["buffers"] = Json::array({{{"byteLength", glb.binary.size()}}});
}

GlbSource emptyGlb() {
    GlbSource glb;
    glb.json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
    for (const char* list : {"scenes", "nodes", "meshes", "accessors", "bufferViews"})
        glb.json[list] = Json::array();
    glb.json["scenes"].push_back({{"nodes", Json::array()}});
    return glb;
}

}  // namespace

Shape plane(float size, int n, float z) {
    Shape shape;
    const float step = size / static_cast<float>(n);
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x)
            shape.positions.emplace_back(static_cast<float>(x) * step, static_cast<float>(y) * step,
                                         z);
    const auto row = static_cast<std::uint32_t>(n + 1);
    for (std::uint32_t y = 0; y + 1 < row; ++y)
        for (std::uint32_t x = 0; x + 1 < row; ++x) {
            const std::uint32_t v = y * row + x;
            addQuad(shape, v, v + 1, v + 1 + row, v + row);
        }
    return shape;
}

Shape cube(float low, float high) {
    Shape shape;
    for (int i = 0; i < 8; ++i)
        shape.positions.emplace_back((i & 1) != 0 ? high : low, (i & 2) != 0 ? high : low,
                                     (i & 4) != 0 ? high : low);
    addQuad(shape, 0, 2, 3, 1);
    addQuad(shape, 4, 5, 7, 6);
    addQuad(shape, 0, 1, 5, 4);
    addQuad(shape, 2, 6, 7, 3);
    addQuad(shape, 0, 4, 6, 2);
    addQuad(shape, 1, 3, 7, 5);
    return shape;
}

Shape ball(const Vector3f& center, float radius, int n) {
    Shape shape;
    const int segments = 2 * n;
    for (int ring = 0; ring <= n; ++ring)
        for (int s = 0; s < segments; ++s) {
            const double polar = kPi * ring / n;
            const double turn = 2 * kPi * s / segments;
            const double wide = ring == 0 || ring == n ? 0 : std::sin(polar);
            shape.positions.push_back(center + radius * Eigen::Vector3d(wide * std::cos(turn),
                                                                        wide * std::sin(turn),
                                                                        std::cos(polar))
                                                            .cast<float>());
        }
    const auto at = [segments](int ring, int s) {
        return static_cast<std::uint32_t>(ring * segments + s % segments);
    };
    for (int ring = 0; ring < n; ++ring)
        for (int s = 0; s < segments; ++s)
            addQuad(shape, at(ring, s), at(ring + 1, s), at(ring + 1, s + 1), at(ring, s + 1));
    return shape;
}

Shape turned(Shape shape) {
    for (auto& triangle : shape.triangles) std::swap(triangle[1], triangle[2]);
    return shape;
}

Shape shifted(Shape shape, const Vector3f& by) {
    for (Vector3f& position : shape.positions) position += by;
    return shape;
}

Shape painted(Shape shape, const Vector3f& color) {
    shape.colors.assign(shape.positions.size(), color);
    return shape;
}

Surface surfaceOf(const std::vector<Shape>& shapes) {
    Surface surface;
    for (const Shape& shape : shapes) {
        const auto first = static_cast<std::uint32_t>(surface.positions.size());
        surface.parts.push_back({"part " + std::to_string(surface.parts.size() + 1),
                                 surface.triangles.size(), shape.triangles.size()});
        surface.positions.insert(surface.positions.end(), shape.positions.begin(),
                                 shape.positions.end());
        surface.colors.insert(surface.colors.end(), shape.colors.begin(), shape.colors.end());
        for (auto triangle : shape.triangles) {
            for (std::uint32_t& v : triangle) v += first;
            surface.triangles.push_back(triangle);
        }
    }
    return surface;
}

std::string container(const std::string& json, const std::string& binary) {
    std::string bytes = "glTF";
    const auto word = [&](std::size_t value) {
        const auto number = static_cast<std::uint32_t>(value);
        bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    };
    const std::size_t jsonPad = (4 - json.size() % 4) % 4;
    const std::size_t binaryPad = (4 - binary.size() % 4) % 4;
    word(2);
    word(12 + 8 + json.size() + jsonPad + 8 + binary.size() + binaryPad);
    word(json.size() + jsonPad);
    bytes += "JSON" + json + std::string(jsonPad, ' ');
    word(binary.size() + binaryPad);
    bytes += std::string("BIN\0", 4) + binary + std::string(binaryPad, '\0');
    return bytes;
}

GlbSource plainGlb(const std::vector<Shape>& shapes, const Json& report) {
    GlbSource glb = emptyGlb();
    if (!report.is_null()) glb.json["asset"]["extras"]["rivage"] = report;
    for (const Shape& shape : shapes) {
        const std::size_t count = shape.positions.size();
        Json primitive;
        primitive["attributes"]["POSITION"] =
            addAccessor(glb, addView(glb, shape.positions), 5126, "VEC3", count);
        if (!shape.colors.empty())
            primitive["attributes"]["COLOR_0"] =
                addAccessor(glb, addView(glb, shape.colors), 5126, "VEC3", count);
        primitive["indices"] = addAccessor(glb, addView(glb, shape.triangles), 5125, "SCALAR",
                                           3 * shape.triangles.size());
        addNode(glb, std::move(primitive));
    }
    return glb;
}

GlbSource dracoGlb(const std::vector<Shape>& shapes, int bits) {
    GlbSource glb = emptyGlb();
    glb.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    for (const Shape& shape : shapes) {
        std::size_t points = 0;
        const std::string stream = dracoStream(shape, bits, points);
        const int view = addView(glb, std::vector<char>(stream.begin(), stream.end()));
        Json primitive;
        primitive["attributes"]["POSITION"] = addAccessor(glb, -1, 5126, "VEC3", points);
        primitive["indices"] = addAccessor(glb, -1, 5125, "SCALAR", 3 * shape.triangles.size());
        primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view},
                                                                 {"attributes", {{"POSITION", 0}}}};
        addNode(glb, std::move(primitive));
    }
    return glb;
}

void refuse(const std::string& bytes, const char* why) {
    CAPTURE(why);
    const auto surface = readSurface(bytes);
    REQUIRE_FALSE(surface);
    CHECK(surface.error().exit == ExitCode::refused);
    const std::string detail = textOf(surface.error().problem, "detail");
    CAPTURE(detail);
    CHECK(detail.find(why) != std::string::npos);
}

}  // namespace rivage::client::test
