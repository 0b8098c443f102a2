#include "core/gltf/glb_model.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "core/base/parallel.h"
#include "core/gltf/gltf_material.h"
#include "core/gltf/json_value.h"

namespace rivage::core {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

// The value that restarts a primitive is no index, so the largest 16-bit index is 65534.
constexpr std::size_t kMaxVertices16 = 65535;

constexpr std::uint32_t kMagic = 0x46546c67;  // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4e4f534a;
constexpr std::uint32_t kBinaryChunk = 0x004e4942;

void append(std::vector<std::byte>& bytes, std::initializer_list<std::uint32_t> words) {
    for (const std::uint32_t word : words)
        for (int shift = 0; shift < 32; shift += 8)
            bytes.push_back(static_cast<std::byte>(word >> shift & 0xff));
}

/// The two chunks as a GLB; empty if `run` asked to stop.
std::vector<std::byte> container(std::string json, std::span<const std::byte> buffer,
                                 const RunContext& run) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t padded = (buffer.size() + 3) / 4 * 4;
    const std::size_t size = 12 + 8 + json.size() + 8 + padded;
    std::vector<std::byte> bytes;
    bytes.reserve(size);
    append(bytes, {kMagic, 2, static_cast<std::uint32_t>(size),
                   static_cast<std::uint32_t>(json.size()), kJsonChunk});
    const auto* first = reinterpret_cast<const std::byte*>(json.data());
    bytes.insert(bytes.end(), first, first + json.size());
    append(bytes, {static_cast<std::uint32_t>(padded), kBinaryChunk});
    constexpr std::size_t kPiece = 1 << 20;
    for (std::size_t at = 0; at < buffer.size(); at += kPiece) {
        if (run.stopped()) return {};
        const auto piece = buffer.subspan(at, std::min(kPiece, buffer.size() - at));
        bytes.insert(bytes.end(), piece.begin(), piece.end());
    }
    bytes.resize(size);
    return bytes;
}

tinygltf::Value number(std::size_t value) { return tinygltf::Value(static_cast<int>(value)); }

template <typename T>
std::span<const std::byte> bytesOf(const std::vector<T>& items) {
    return std::as_bytes(std::span(items));
}

}  // namespace

void GlbModel::beginPart(const MeshPart& part) {
    tinygltf::Mesh mesh;
    mesh.name = validUtf8(part.name);
    tinygltf::Node node;
    node.name = mesh.name;
    node.mesh = static_cast<int>(model_.meshes.size());
    node.extras = toValue({{"inner", part.inner}, {"outer", part.outer}});
    model_.meshes.push_back(std::move(mesh));
    model_.nodes.push_back(std::move(node));
}

int GlbModel::addView(std::span<const std::byte> bytes, int target) {
    buffer_.resize((buffer_.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer_.size();
    view.byteLength = bytes.size();
    view.target = target;
    const auto* first = reinterpret_cast<const unsigned char*>(bytes.data());
    buffer_.insert(buffer_.end(), first, first + bytes.size());
    model_.bufferViews.push_back(std::move(view));
    return static_cast<int>(model_.bufferViews.size()) - 1;
}

int GlbModel::addAccessor(int view, const AccessorKind& kind, std::size_t count) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.byteOffset = 0;
    accessor.componentType = kind.componentType;
    accessor.type = kind.type;
    accessor.normalized = kind.normalized;
    accessor.count = count;
    model_.accessors.push_back(std::move(accessor));
    return static_cast<int>(model_.accessors.size()) - 1;
}

void GlbModel::setBounds(int accessor, const std::array<float, 3>& low,
                         const std::array<float, 3>& high) {
    model_.accessors[accessor].minValues.assign(low.begin(), low.end());
    model_.accessors[accessor].maxValues.assign(high.begin(), high.end());
}

void GlbModel::addDraco(const DracoPrimitive& encoded, std::uint32_t material) {
    constexpr AccessorKind kVec3{TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3};
    constexpr AccessorKind kColor{TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4, true};
    usesDraco_ = true;
    tinygltf::Primitive out;
    out.mode = TINYGLTF_MODE_TRIANGLES;
    out.material = static_cast<int>(material);
    tinygltf::Value::Object ids;
    const auto add = [&](const char* name, const AccessorKind& kind, std::uint32_t id) {
        out.attributes[name] = addAccessor(-1, kind, encoded.vertices);
        ids[name] = number(id);
    };
    add("POSITION", kVec3, encoded.positionId);
    setBounds(out.attributes["POSITION"], encoded.low, encoded.high);
    if (encoded.normalId) add("NORMAL", kVec3, *encoded.normalId);
    if (encoded.colorId) add("COLOR_0", kColor, *encoded.colorId);
    const int indexType = encoded.vertices <= kMaxVertices16
                              ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                              : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    out.indices = addAccessor(-1, {indexType, TINYGLTF_TYPE_SCALAR}, 3 * encoded.triangles);
    const int view = addView(encoded.bytes, 0);
    out.extensions[kDraco] = tinygltf::Value(tinygltf::Value::Object{
        {"bufferView", number(view)}, {"attributes", tinygltf::Value(std::move(ids))}});
    model_.meshes.back().primitives.push_back(std::move(out));
}

void GlbModel::addPlainIndices(const MeshPrimitive& primitive, const RunContext& run,
                               tinygltf::Primitive& out) {
    const auto addAs = [&]<typename Index>(Index, int componentType) {
        std::vector<Index> indices;
        indices.reserve(6 * primitive.quads.size());
        serialFor(primitive.quads.size(), run, [&](std::size_t q) {
            for (const int k : {0, 1, 2, 0, 2, 3})
                indices.push_back(static_cast<Index>(primitive.quads[q][k]));
        });
        const int view = addView(bytesOf(indices), TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
        out.indices = addAccessor(view, {componentType, TINYGLTF_TYPE_SCALAR}, indices.size());
    };
    if (primitive.positions.size() <= kMaxVertices16)
        addAs(std::uint16_t{}, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
    else
        addAs(std::uint32_t{}, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
}

void GlbModel::addPlain(const MeshPrimitive& primitive, const Placement& placement,
                        const RunContext& run) {
    constexpr int kVertices = TINYGLTF_TARGET_ARRAY_BUFFER;
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    tinygltf::Primitive out;
    out.mode = TINYGLTF_MODE_TRIANGLES;
    out.material = static_cast<int>(primitive.material);
    std::array<float, 3> low{kInfinity, kInfinity, kInfinity};
    std::array<float, 3> high{-kInfinity, -kInfinity, -kInfinity};
    std::vector<std::array<float, 3>> rows;
    rows.reserve(primitive.positions.size());
    serialFor(primitive.positions.size(), run, [&](std::size_t v) {
        const Vec3f p = placement.position(primitive.positions[v]);
        for (int i = 0; i < 3; ++i) {
            low[i] = std::min(low[i], p[i]);
            high[i] = std::max(high[i], p[i]);
        }
        rows.push_back({p.x(), p.y(), p.z()});
    });
    const auto addRows = [&] {
        return addAccessor(addView(bytesOf(rows), kVertices),
                           {TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3}, rows.size());
    };
    out.attributes["POSITION"] = addRows();
    setBounds(out.attributes["POSITION"], low, high);
    rows.clear();
    serialFor(primitive.normals.size(), run, [&](std::size_t v) {
        const Vec3f n = placement.direction(primitive.normals[v].cast<double>()).cast<float>();
        rows.push_back({n.x(), n.y(), n.z()});
    });
    if (!rows.empty()) out.attributes["NORMAL"] = addRows();
    if (!primitive.colors.empty())
        out.attributes["COLOR_0"] =
            addAccessor(addView(bytesOf(primitive.colors), kVertices),
                        {TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4, true},
                        primitive.colors.size());
    addPlainIndices(primitive, run, out);
    model_.meshes.back().primitives.push_back(std::move(out));
}

std::vector<std::byte> GlbModel::finish(const std::vector<MeshMaterial>& materials,
                                        const tinygltf::Value& report, const RunContext& run) {
    for (const MeshMaterial& material : materials)
        model_.materials.push_back(toGltf(material, extensions_));
    if (usesDraco_) {
        extensions_.insert(kDraco);
        model_.extensionsRequired = {kDraco};
    }
    model_.extensionsUsed.assign(extensions_.begin(), extensions_.end());
    model_.asset.version = "2.0";
    model_.asset.generator = "Rivage " RIVAGE_VERSION;
    model_.asset.extras = tinygltf::Value(tinygltf::Value::Object{{"rivage", report}});
    tinygltf::Scene scene;
    for (std::size_t i = 0; i < model_.nodes.size(); ++i)
        scene.nodes.push_back(static_cast<int>(i));
    model_.scenes.push_back(std::move(scene));
    model_.defaultScene = 0;

    // The library would copy the buffer twice; a gigabyte takes so long that one may want to stop.
    std::ostringstream text;
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, text, false, false)) return {};
    auto json = nlohmann::json::parse(text.str());
    json["buffers"] = {{{"byteLength", buffer_.size()}}};
    return container(json.dump(), std::as_bytes(std::span(buffer_)), run);
}

}  // namespace rivage::core
