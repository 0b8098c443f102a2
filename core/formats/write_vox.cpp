#include "core/formats/write_vox.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "core/formats/vox_chunk_writer.h"

namespace rivage::core {
namespace {

constexpr int kMaxModelSide = 256;
constexpr std::size_t kMaxColors = 255;
constexpr std::size_t kColorsPerRow = 8;
constexpr std::size_t kRows = 32;
constexpr Rgba8 kUnusedColor = {75, 75, 75, 255};

using Pairs = std::vector<std::pair<std::string, std::string>>;

/// The shortest text that reads back as the same number.
std::string text(double value) {
    std::array<char, 32> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    return {buffer.data(), end};
}

void writeModel(const BrickGrid& model, ChunkWriter& out) {
    ChunkWriter size;
    for (int axis = 0; axis < 3; ++axis) size.i32(model.size()[axis]);
    out.chunk("SIZE", size);
    ChunkWriter voxels;
    voxels.u32(static_cast<std::uint32_t>(model.countVoxels()));
    model.forEach([&](const Vec3i& voxel, MaterialId material) {
        for (int axis = 0; axis < 3; ++axis) voxels.u8(static_cast<std::uint32_t>(voxel[axis]));
        voxels.u8(index(material));
    });
    out.chunk("XYZI", voxels);
}

/// Columns of rows 0 and 1 and the signs of all rows, as the `_r` byte.
int rotationBits(const Mat3i& rotation) {
    Vec3i column;
    int bits = 0;
    for (int row = 0; row < 3; ++row) {
        rotation.row(row).cwiseAbs().maxCoeff(&column[row]);
        if (rotation(row, column[row]) < 0) bits |= 1 << (4 + row);
    }
    return bits | column[0] | column[1] << 2;
}

/// The translation of the rotated pivot floor(size / 2), which is what the format stores.
Vec3i pivotTranslation(const Instance& instance, const Vec3i& size) {
    if (instance.centered) return instance.translation;
    Vec3i translation = instance.translation;
    for (int row = 0; row < 3; ++row) {
        int column = 0;
        instance.rotation.row(row).cwiseAbs().maxCoeff(&column);
        const int side = size[column];
        translation[row] += instance.rotation(row, column) > 0 ? side / 2 : side - side / 2;
    }
    return translation;
}

void writeInstance(const Instance& instance, const Scene& scene, std::uint32_t node,
                   ChunkWriter& out) {
    Pairs attributes;
    if (!instance.name.empty()) attributes.emplace_back("_name", instance.name);
    if (instance.hidden) attributes.emplace_back("_hidden", "1");
    const Vec3i& size = scene.models[static_cast<std::size_t>(instance.frames[0])].size();
    const Vec3i at = pivotTranslation(instance, size);
    Pairs frame;
    if (instance.rotation != Mat3i::Identity())
        frame.emplace_back("_r", std::to_string(rotationBits(instance.rotation)));
    frame.emplace_back(
        "_t", std::to_string(at.x()) + " " + std::to_string(at.y()) + " " + std::to_string(at.z()));
    ChunkWriter transform;
    transform.u32(node).dict(attributes).u32(node + 1).i32(-1).i32(instance.layer).u32(1);
    transform.dict(frame);
    out.chunk("nTRN", transform);

    ChunkWriter shape;
    shape.u32(node + 1).dict({}).u32(static_cast<std::uint32_t>(instance.frames.size()));
    for (std::size_t k = 0; k < instance.frames.size(); ++k) {
        const int time = instance.frameTimes.empty() ? static_cast<int>(k) : instance.frameTimes[k];
        Pairs model;
        if (instance.frames.size() > 1) model.emplace_back("_f", std::to_string(time));
        shape.i32(instance.frames[k]).dict(model);
    }
    out.chunk("nSHP", shape);
}

/// Node 0 is the root transform and 1 its group; instance i has the nodes 2 + 2i and 3 + 2i.
/// In version 200 the earlier of two overlapping instances is seen.
void writeSceneGraph(const Scene& scene, ChunkWriter& out) {
    out.chunk("nTRN", ChunkWriter().u32(0).dict({}).u32(1).i32(-1).i32(-1).u32(1).dict({}));
    const std::size_t count = scene.instances.size();
    ChunkWriter group;
    group.u32(1).dict({}).u32(static_cast<std::uint32_t>(count));
    for (std::uint32_t i = 0; i < count; ++i) group.u32(2 + 2 * i);
    out.chunk("nGRP", group);
    std::set<int> layers;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Instance& instance = scene.instances[scene.laterInstanceWins ? count - 1 - i : i];
        writeInstance(instance, scene, 2 + 2 * i, out);
        if (instance.layer >= 0) layers.insert(instance.layer);
    }
    for (const int layer : layers) out.chunk("LAYR", ChunkWriter().i32(layer).dict({}).i32(-1));
}

Pairs propertiesOf(const Material& material) {
    Pairs pairs;
    const auto add = [&](const char* key, double value) { pairs.emplace_back(key, text(value)); };
    const auto head = [&](const char* type) {
        pairs.emplace_back("_type", type);
        add("_rough", material.roughness);
        add("_ri", material.ior);
        add("_ior", material.ior - 1);
    };
    switch (material.kind) {
        case MaterialClass::opaque: break;
        case MaterialClass::metal:
            head("_metal");
            add("_metal", material.metallic);
            break;
        case MaterialClass::glass:
        case MaterialClass::cloud:
            head(material.kind == MaterialClass::glass ? "_glass" : "_media");
            add("_alpha", material.transmission);
            add("_trans", material.transmission);
            break;
        case MaterialClass::emissive:
            head("_emit");
            add("_emit", material.emission);
            add("_flux", std::log2(std::max(material.emissiveStrength, 2.0)) - 1);
            break;
    }
    return pairs;
}

void writePalette(const IdVector<MaterialId, Material>& materials, ChunkWriter& out) {
    ChunkWriter palette;
    std::array<std::string, kRows> rowNames;
    bool named = false;
    for (std::size_t i = 1; i <= kMaxColors + 1; ++i) {
        const bool exists = i < materials.size();
        const Rgba8 color = exists ? materials.raw()[i].color : kUnusedColor;
        for (const std::uint8_t channel : color) palette.u8(channel);
        if (!exists || materials.raw()[i].name.empty()) continue;
        std::string& row = rowNames[(i - 1) / kColorsPerRow];
        if (row.empty()) row = materials.raw()[i].name;
        named = true;
    }
    out.chunk("RGBA", palette);
    for (std::size_t i = 1; i < materials.size(); ++i)
        if (const Pairs pairs = propertiesOf(materials.raw()[i]); !pairs.empty())
            out.chunk("MATL", ChunkWriter().u32(static_cast<std::uint32_t>(i)).dict(pairs));
    if (!named) return;
    ChunkWriter notes;  // from the top row of the palette, which holds the highest entries
    notes.u32(kRows);
    for (auto row = rowNames.rbegin(); row != rowNames.rend(); ++row) notes.string(*row);
    out.chunk("NOTE", notes);
}

Result<void> checkWritable(const Scene& scene) {
    const bool placed = std::all_of(scene.instances.begin(), scene.instances.end(),
                                    [](const Instance& i) { return !i.frames.empty(); });
    if (scene.models.empty() || scene.instances.empty() || !placed)
        return fail(ErrorCode::emptyGrid, "a scene without a placed model cannot be written",
                    "/grid");
    for (const BrickGrid& model : scene.models)
        if (model.size().maxCoeff() > kMaxModelSide)
            return fail(Error{ErrorCode::tooLarge, "a .vox model is at most 256 voxels long",
                              "/grid", kMaxModelSide,
                              static_cast<std::uint64_t>(model.size().maxCoeff())});
    if (scene.materials.size() > kMaxColors + 1)
        return fail(Error{ErrorCode::tooManyLabels, "a .vox file has at most 255 materials",
                          "/grid", kMaxColors, scene.materials.size() - 1});
    return {};
}

}  // namespace

Result<std::vector<std::byte>> writeVox(const Scene& scene) {
    if (const Result<void> writable = checkWritable(scene); !writable)
        return fail(writable.error());
    ChunkWriter children;
    for (const BrickGrid& model : scene.models) writeModel(model, children);
    writeSceneGraph(scene, children);
    writePalette(scene.materials, children);
    if (children.size() > std::numeric_limits<std::uint32_t>::max())
        return fail(Error{ErrorCode::outputTooLarge, "a .vox file is at most 4 GiB long", "/grid",
                          std::numeric_limits<std::uint32_t>::max(), children.size()});
    ChunkWriter file;
    file.raw("VOX ").u32(200).raw("MAIN").u32(0).u32(static_cast<std::uint32_t>(children.size()));
    std::vector<std::byte> bytes = std::move(file).take();
    const std::vector<std::byte> inner = std::move(children).take();
    bytes.insert(bytes.end(), inner.begin(), inner.end());
    return bytes;
}

}  // namespace rivage::core
