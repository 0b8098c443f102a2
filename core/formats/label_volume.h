#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/base/vec.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// How the values of a dense volume are stored.
struct ValueType {
    int bytes = 1;  ///< 1, 2, 4 or 8
    bool isSigned = false;
    bool bigEndian = false;
    bool isBoolean = false;  ///< every value but 0 counts as 1
    bool isFloat = false;    ///< of 4 or 8 bytes; the values are whole all the same
};

/// A scene of one model from a dense volume of values: 0 is empty, and the other values that
/// occur become materials 1, 2, ... in ascending order, each with `source` = its value and a
/// colour of its own that depends on the value only.
///
/// @param values  exactly size.x * size.y * size.z values, x fastest, then y, then z
/// @param size    at least 1 along each axis
/// @errors        malformedInput on a value that is no whole number from 0 to 2^32 - 1; tooManyLabels above
///                `maxMaterials` values; tooLarge by extent; memoryBudget; emptyGrid; cancelled
/// @cost          O(values * log(distinct values above 65535)) time, 2 bytes per voxel in bricks
Result<Scene> sceneFromVolume(std::span<const std::byte> values, const ValueType& type,
                              const Vec3i& size, const RunContext& run);

/// Bytes of size.x * size.y * size.z values; nothing if that is not below 2^63.
[[nodiscard]] std::optional<std::uint64_t> volumeBytes(const Vec3i& size, const ValueType& type);

/// Refuses a size below 1 or above `limits.maxExtent`, and volumes above `limits.maxInputBytes`.
/// @errors invalidOption or malformedInput (`code`) below 1; tooLarge
Result<std::uint64_t> checkVolumeSize(const Vec3i& size, const ValueType& type,
                                      const Limits& limits, ErrorCode code,
                                      const std::string& field);

/// The display colour of a stored value: golden-ratio steps of hue at one lightness.
[[nodiscard]] Rgba8 valueColor(std::uint32_t value);

}  // namespace rivage::core
