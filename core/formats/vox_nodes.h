#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/formats/byte_reader.h"
#include "core/formats/vox_document.h"

namespace rivage::core {

/// Shorthand for the error of a .vox file that breaks its format.
[[nodiscard]] tl::unexpected<Error> voxError(std::string message, std::string field);

/// Reads a DICT; the reader is failed afterwards if it does not fit.
[[nodiscard]] VoxDict readDict(ByteReader& reader);

/// One node of the scene graph from the content of its chunk; a transform keeps only the pose that
/// holds at `frame`, so that its memory does not grow with its keys.
/// @errors malformedInput if the content ends early, or a rotation, translation or frame is wrong
Result<VoxNode> parseTransformNode(std::span<const std::byte> content, int frame);
Result<VoxNode> parseGroupNode(std::span<const std::byte> content);
Result<VoxNode> parseShapeNode(std::span<const std::byte> content);

}  // namespace rivage::core
