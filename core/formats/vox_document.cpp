#include "core/formats/vox_document.h"

#include <bit>
#include <cmath>
#include <string>

#include "core/formats/byte_reader.h"
#include "core/formats/vox_nodes.h"

namespace rivage::core {
namespace {

constexpr std::uint32_t kMaxModelSide = 256;  // a coordinate is stored in one byte
constexpr std::uint32_t kNodesPerModel = 4;   // a transform, a shape and room for groups

struct Chunk {
    std::string_view id;
    std::span<const std::byte> content;
};

/// Turns the chunks inside MAIN into a document, one after the other.
class DocumentBuilder {
public:
    DocumentBuilder(int version, int frame, const Limits& limits) : limits_(limits), frame_(frame) {
        document_.version = version;
    }

    Result<void> add(const Chunk& chunk) {
        if (chunk.id == "SIZE") return addSize(chunk.content);
        if (chunk.id == "XYZI") return addVoxels(chunk.content);
        if (chunk.id == "PACK") return addPack(chunk.content);
        if (chunk.id == "RGBA") return addPalette(chunk.content);
        if (chunk.id == "IMAP") return addDisplayOrder(chunk.content);
        if (chunk.id == "nTRN") return addNode(parseTransformNode(chunk.content, frame_));
        if (chunk.id == "nGRP") return addNode(parseGroupNode(chunk.content));
        if (chunk.id == "nSHP") return addNode(parseShapeNode(chunk.content));
        if (chunk.id == "LAYR") return addLayer(chunk.content);
        if (chunk.id == "MATL") return addMaterial(chunk.content);
        if (chunk.id == "MATT") return addLegacyMaterial(chunk.content);
        if (chunk.id == "NOTE") return addNotes(chunk.content);
        return {};
    }

    Result<VoxDocument> finish() && {
        if (sizePending_) return voxError("the last SIZE chunk has no XYZI chunk", modelField());
        return std::move(document_);
    }

private:
    [[nodiscard]] std::string modelField(const char* part = "") const {
        const std::size_t open = document_.models.size() - (sizePending_ ? 1 : 0);
        return "/grid/models/" + std::to_string(open) + part;
    }

    Result<void> addSize(std::span<const std::byte> content);
    Result<void> addVoxels(std::span<const std::byte> content);
    Result<void> addPack(std::span<const std::byte> content);
    Result<void> addPalette(std::span<const std::byte> content);
    Result<void> addDisplayOrder(std::span<const std::byte> content);
    Result<void> addNode(Result<VoxNode> node);
    Result<void> addLayer(std::span<const std::byte> content);
    Result<void> addMaterial(std::span<const std::byte> content);
    Result<void> addLegacyMaterial(std::span<const std::byte> content);
    Result<void> addNotes(std::span<const std::byte> content);

    const Limits& limits_;
    int frame_;
    VoxDocument document_;
    bool sizePending_ = false;
};

Result<void> DocumentBuilder::addSize(std::span<const std::byte> content) {
    if (sizePending_) return voxError("two SIZE chunks without an XYZI between them", modelField());
    if (document_.models.size() >= limits_.maxModels)
        return fail(Error{ErrorCode::tooLarge, "the scene has too many models", "/grid/models",
                          limits_.maxModels, document_.models.size() + 1, "--max-models"});
    if (content.size() != 12)
        return voxError("a SIZE chunk must hold 12 bytes", modelField("/size"));
    ByteReader reader(content);
    VoxModel model;
    for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t side = reader.u32();
        if (side == 0 || side > kMaxModelSide)
            return fail(Error{ErrorCode::malformedInput,
                              "a model must be 1 to 256 voxels long along every axis, not " +
                                  std::to_string(side),
                              modelField("/size"), kMaxModelSide, side});
        model.size[axis] = static_cast<int>(side);
    }
    document_.models.push_back(model);
    sizePending_ = true;
    return {};
}

Result<void> DocumentBuilder::addVoxels(std::span<const std::byte> content) {
    if (!sizePending_) return voxError("an XYZI chunk without a SIZE before it", modelField());
    ByteReader reader(content);
    const std::uint64_t count = reader.u32();
    const std::uint64_t stored = reader.remaining() / 4;
    if (!reader.ok() || reader.remaining() != count * 4)
        return fail(Error{ErrorCode::malformedInput,
                          "an XYZI chunk announces " + std::to_string(count) +
                              " voxels and has room for " + std::to_string(stored),
                          modelField("/voxels"), stored, count});
    document_.models.back().voxels = reader.bytes(count * 4);
    sizePending_ = false;
    return {};
}

Result<void> DocumentBuilder::addPack(std::span<const std::byte> content) {
    if (content.size() != 4) return voxError("a PACK chunk must hold 4 bytes", "/grid/pack");
    document_.packed = ByteReader(content).u32();
    return {};
}

Result<void> DocumentBuilder::addPalette(std::span<const std::byte> content) {
    if (content.size() != 1024)
        return voxError("an RGBA chunk must hold 256 colours of 4 bytes", "/grid/palette");
    auto& palette = document_.palette.emplace();
    for (std::size_t i = 0; i < 1024; ++i)
        palette[i / 4][i % 4] = std::to_integer<std::uint8_t>(content[i]);
    return {};
}

Result<void> DocumentBuilder::addDisplayOrder(std::span<const std::byte> content) {
    if (content.size() != 256)
        return voxError("an IMAP chunk must hold 256 bytes", "/grid/palette/order");
    auto& order = document_.displayOrder.emplace();
    std::array<bool, 256> seen{};
    for (std::size_t i = 0; i < 256; ++i) {
        order[i] = std::to_integer<std::uint8_t>(content[i]);
        if (seen[order[i]])
            return voxError("an IMAP chunk names a colour twice", "/grid/palette/order");
        seen[order[i]] = true;
    }
    return {};
}

Result<void> DocumentBuilder::addNode(Result<VoxNode> node) {
    if (!node) return fail(std::move(node.error()));
    const std::uint64_t limit = limits_.maxModels * kNodesPerModel;
    if (document_.nodes.size() >= limit)
        return fail(Error{ErrorCode::tooLarge, "the scene graph has too many nodes", "/grid/nodes",
                          limit, document_.nodes.size() + 1, "--max-models"});
    document_.nodes.push_back(*std::move(node));
    return {};
}

Result<void> DocumentBuilder::addLayer(std::span<const std::byte> content) {
    ByteReader reader(content);
    const int id = reader.i32();
    const VoxDict attributes = readDict(reader);
    if (!reader.ok()) return voxError("a LAYR chunk ends early", "/grid/layers");
    document_.hiddenLayers[id] = valueOf(attributes, "_hidden") == "1";
    return {};
}

Result<void> DocumentBuilder::addMaterial(std::span<const std::byte> content) {
    ByteReader reader(content);
    const std::uint32_t id = reader.u32();
    VoxDict properties = readDict(reader);
    if (!reader.ok()) return voxError("a MATL chunk ends early", "/grid/materials");
    if (id >= 1 && id <= 255) document_.materials[id] = std::move(properties);
    return {};
}

Result<void> DocumentBuilder::addLegacyMaterial(std::span<const std::byte> content) {
    ByteReader reader(content);
    const std::uint32_t id = reader.u32();
    VoxLegacyMaterial material;
    material.type = reader.u32();
    material.weight = std::bit_cast<float>(reader.u32());
    const std::uint32_t present = reader.u32();
    for (unsigned bit = 0; bit < 7; ++bit)  // bit 7 is a flag without a value
        if (present >> bit & 1) material.values[bit] = std::bit_cast<float>(reader.u32());
    if (!reader.ok()) return voxError("a MATT chunk ends early", "/grid/materials");
    if (id >= 1 && id <= 255) document_.legacyMaterials[id] = material;
    return {};
}

Result<void> DocumentBuilder::addNotes(std::span<const std::byte> content) {
    ByteReader reader(content);
    const std::uint32_t count = reader.u32();
    document_.rowNames.clear();
    for (std::uint32_t i = 0; i < count && reader.ok(); ++i)
        document_.rowNames.push_back(reader.text(reader.u32()));
    if (!reader.ok()) return voxError("a NOTE chunk ends early", "/grid/palette/notes");
    return {};
}

/// The next chunk of `reader` without its children; those are skipped.
Result<Chunk> readChunk(ByteReader& reader) {
    const std::size_t start = reader.offset();
    Chunk chunk;
    chunk.id = reader.text(4);
    const std::uint64_t contentBytes = reader.u32();
    const std::uint64_t childBytes = reader.u32();
    const bool headerFits = reader.ok();
    const std::uint64_t room = reader.remaining();
    chunk.content = reader.bytes(contentBytes);
    reader.bytes(childBytes);
    if (reader.ok()) return chunk;
    Error error{ErrorCode::malformedInput,
                "the chunk at byte " + std::to_string(start) + " of MAIN ends after its parent",
                "/grid"};
    if (headerFits) {
        error.limit = room;
        error.actual = contentBytes + childBytes;
    }
    return fail(std::move(error));
}

/// The bytes inside MAIN, which must reach exactly to the end of the file.
Result<std::span<const std::byte>> mainChildren(ByteReader& reader) {
    const std::string_view id = reader.text(4);
    const std::uint64_t contentBytes = reader.u32();
    const std::uint64_t childBytes = reader.u32();
    if (!reader.ok()) return voxError("the file ends inside the header of MAIN", "/grid");
    if (id != "MAIN") return voxError("the first chunk is not MAIN", "/grid");
    const std::uint64_t room = reader.remaining();
    const std::uint64_t announced = contentBytes + childBytes;
    if (announced > room)
        return fail(Error{ErrorCode::malformedInput,
                          "the file is truncated: MAIN announces " + std::to_string(announced) +
                              " bytes and " + std::to_string(room) + " follow",
                          "/grid", room, announced});
    if (announced < room)
        return voxError(std::to_string(room - announced) + " bytes follow the end of MAIN",
                        "/grid");
    reader.bytes(contentBytes);
    return reader.bytes(childBytes);
}

}  // namespace

std::string_view valueOf(const VoxDict& dict, std::string_view key) {
    for (const auto& [name, value] : dict)
        if (name == key) return value;
    return {};
}

Result<VoxDocument> parseVoxDocument(std::span<const std::byte> bytes, int frame,
                                     const Limits& limits) {
    ByteReader reader(bytes);
    if (reader.text(4) != "VOX ") return voxError("the file does not start with 'VOX '", "/grid");
    const int version = reader.i32();
    if (!reader.ok()) return voxError("the file ends inside its header", "/grid");
    if (version != 150 && version != 200)
        return fail(ErrorCode::unsupportedFormat,
                    "MagicaVoxel version " + std::to_string(version) +
                        " is not supported; versions 150 and 200 are",
                    "/grid/version");
    const auto children = mainChildren(reader);
    if (!children) return fail(children.error());

    DocumentBuilder builder(version, frame, limits);
    ByteReader chunks(*children);
    while (chunks.remaining() > 0) {
        const Result<Chunk> chunk = readChunk(chunks);
        if (!chunk) return fail(chunk.error());
        if (const Result<void> added = builder.add(*chunk); !added) return fail(added.error());
    }
    return std::move(builder).finish();
}

}  // namespace rivage::core
