#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/base/vec.h"
#include "core/grid/material.h"

/// The chunks of a .vox file as values, still without meaning: `vox_scene_graph.h` and
/// `vox_materials.h` give it. Every view points into the bytes that were parsed.
namespace rivage::core {

/// Voxels of one model as stored: 4 bytes each (x, y, z, colour index).
struct VoxModel {
    Vec3i size = Vec3i::Zero();  ///< 1..256 along each axis
    std::span<const std::byte> voxels;
};

/// Key and value pairs in file order.
using VoxDict = std::vector<std::pair<std::string_view, std::string_view>>;
/// The value of the first such key; empty if there is none.
[[nodiscard]] std::string_view valueOf(const VoxDict& dict, std::string_view key);

enum class VoxNodeKind : std::uint8_t { transform, group, shape };

/// Where a transform puts its child.
struct VoxPose {
    Mat3i rotation = Mat3i::Identity();
    Vec3i translation = Vec3i::Zero();
};
/// Which model a shape shows from frame `time` on.
struct VoxShown {
    int time = 0;
    std::uint32_t model = 0;
};

struct VoxNode {
    std::uint32_t id = 0;
    VoxNodeKind kind = VoxNodeKind::group;
    bool hidden = false;
    int layer = -1;  ///< transforms only
    std::string_view name;
    std::vector<std::uint32_t> children;  ///< node ids; a transform has one, a shape none
    VoxPose pose;                         ///< transforms only, at the frame that was asked for
    std::vector<VoxShown> shown;          ///< shapes only, at least one, ascending times
};

/// The legacy binary material of version 150.
struct VoxLegacyMaterial {
    std::uint32_t type = 0;  ///< 0 diffuse, 1 metal, 2 glass, 3 emissive
    double weight = 1;
    std::array<std::optional<double>, 8> values;  ///< by property bit
};

struct VoxDocument {
    int version = 0;
    std::vector<VoxModel> models;
    std::optional<std::uint32_t> packed;            ///< models that PACK announces
    std::optional<std::array<Rgba8, 256>> palette;  ///< entry i belongs to colour index i + 1
    std::optional<std::array<std::uint8_t, 256>> displayOrder;  ///< IMAP
    std::vector<VoxNode> nodes;
    std::map<int, bool> hiddenLayers;            ///< layer id -> hidden
    std::map<std::uint32_t, VoxDict> materials;  ///< MATL by id 1..255
    std::map<std::uint32_t, VoxLegacyMaterial> legacyMaterials;
    std::vector<std::string_view> rowNames;  ///< NOTE
};

/// Parses the container and every chunk that matters; unknown chunks are skipped.
/// @param frame  decides which key of an animated transform holds
/// @errors unsupportedFormat if the version is neither 150 nor 200; malformedInput if a chunk
///         leaves its parent, a count leaves its chunk or bytes follow MAIN; tooLarge above
///         `limits.maxModels` models or four times as many nodes
/// @cost   O(bytes) time and memory
Result<VoxDocument> parseVoxDocument(std::span<const std::byte> bytes, int frame,
                                     const Limits& limits);

}  // namespace rivage::core
