#include "core/formats/vox_nodes.h"

#include <charconv>
#include <utility>

#include "core/formats/clean_text.h"

namespace rivage::core {
namespace {

std::string nodeField(std::uint32_t id, const char* part = "") {
    return "/grid/nodes/" + std::to_string(id) + part;
}

/// Takes one whole number off the front of `text`, with the spaces before it.
std::optional<int> takeInt(std::string_view& text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
}

/// A text that is one whole number.
std::optional<int> wholeInt(std::string_view text) {
    const std::optional<int> value = takeInt(text);
    return text.empty() ? value : std::nullopt;
}

/// Bits 0-1 and 2-3: the column of the entry in rows 0 and 1; bits 4-6: the signs of the rows.
std::optional<Mat3i> rotationOf(std::string_view text) {
    const std::optional<int> bits = wholeInt(text);
    if (!bits || *bits < 0 || *bits > 127) return std::nullopt;
    const int first = *bits & 3;
    const int second = *bits >> 2 & 3;
    if (first == 3 || second == 3 || first == second) return std::nullopt;
    const int columns[3] = {first, second, 3 - first - second};
    Mat3i rotation = Mat3i::Zero();
    for (int row = 0; row < 3; ++row) rotation(row, columns[row]) = *bits >> (4 + row) & 1 ? -1 : 1;
    return rotation;
}

std::optional<Vec3i> translationOf(std::string_view text) {
    Vec3i translation;
    for (int axis = 0; axis < 3; ++axis) {
        const std::optional<int> value = takeInt(text);
        if (!value) return std::nullopt;
        translation[axis] = *value;
    }
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    return text.empty() ? std::optional(translation) : std::nullopt;
}

/// The frame of a key: `_f` where it is given, its number otherwise; -1 if it is malformed or
/// does not lie after the key before it.
int timeOf(const VoxDict& dict, std::size_t number, int previous) {
    const std::string_view text = valueOf(dict, "_f");
    const std::optional<int> time = text.empty() ? static_cast<int>(number) : wholeInt(text);
    return time && *time > previous ? *time : -1;
}

VoxNode nodeHead(VoxNodeKind kind, ByteReader& reader) {
    VoxNode node;
    node.kind = kind;
    node.id = reader.u32();
    const VoxDict attributes = readDict(reader);
    node.name = valueOf(attributes, "_name");
    node.hidden = valueOf(attributes, "_hidden") == "1";
    return node;
}

Result<VoxPose> poseOf(const VoxDict& dict, std::uint32_t id) {
    VoxPose pose;
    if (const auto text = valueOf(dict, "_r"); !text.empty()) {
        const auto rotation = rotationOf(text);
        if (!rotation)
            return voxError("rotation '" + cleanText(text.substr(0, 12)) +
                                "' of a transform node is not a signed permutation",
                            nodeField(id, "/_r"));
        pose.rotation = *rotation;
    }
    if (const auto text = valueOf(dict, "_t"); !text.empty()) {
        const auto translation = translationOf(text);
        if (!translation)
            return voxError("a translation of a transform node is not three whole numbers",
                            nodeField(id, "/_t"));
        pose.translation = *translation;
    }
    return pose;
}

tl::unexpected<Error> truncated(const VoxNode& node) {
    return voxError("a scene graph chunk ends before its counts are satisfied", nodeField(node.id));
}

tl::unexpected<Error> badTime(const VoxNode& node) {
    return voxError("the frames of a node are not whole numbers in ascending order",
                    nodeField(node.id, "/_f"));
}

}  // namespace

tl::unexpected<Error> voxError(std::string message, std::string field) {
    return fail(ErrorCode::malformedInput, std::move(message), std::move(field));
}

VoxDict readDict(ByteReader& reader) {
    VoxDict dict;
    const std::uint32_t pairs = reader.u32();
    for (std::uint32_t i = 0; i < pairs && reader.ok(); ++i) {
        const std::string_view key = reader.text(reader.u32());
        const std::string_view value = reader.text(reader.u32());
        if (reader.ok()) dict.emplace_back(key, value);
    }
    return dict;
}

Result<VoxNode> parseTransformNode(std::span<const std::byte> content, int frame) {
    ByteReader reader(content);
    VoxNode node = nodeHead(VoxNodeKind::transform, reader);
    node.children.push_back(reader.u32());
    reader.u32();  // reserved
    node.layer = reader.i32();
    const std::uint32_t frames = reader.u32();
    if (!reader.ok()) return truncated(node);
    int time = -1;
    for (std::uint32_t i = 0; i < frames; ++i) {
        const VoxDict dict = readDict(reader);
        if (!reader.ok()) return truncated(node);
        const Result<VoxPose> pose = poseOf(dict, node.id);
        if (!pose) return fail(pose.error());
        time = timeOf(dict, i, time);
        if (time < 0) return badTime(node);
        if (i == 0 || time <= frame) node.pose = *pose;
    }
    return node;
}

Result<VoxNode> parseGroupNode(std::span<const std::byte> content) {
    ByteReader reader(content);
    VoxNode node = nodeHead(VoxNodeKind::group, reader);
    const std::uint64_t count = reader.u32();
    if (!reader.ok() || count > reader.remaining() / 4) return truncated(node);
    node.children.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) node.children.push_back(reader.u32());
    return node;
}

Result<VoxNode> parseShapeNode(std::span<const std::byte> content) {
    ByteReader reader(content);
    VoxNode node = nodeHead(VoxNodeKind::shape, reader);
    const std::uint32_t count = reader.u32();
    if (!reader.ok()) return truncated(node);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t model = reader.u32();
        const VoxDict dict = readDict(reader);
        if (!reader.ok()) return truncated(node);
        const int time = timeOf(dict, i, node.shown.empty() ? -1 : node.shown.back().time);
        if (time < 0) return badTime(node);
        node.shown.push_back({time, model});
    }
    if (node.shown.empty()) return voxError("a shape node shows no model", nodeField(node.id));
    return node;
}

}  // namespace rivage::core
