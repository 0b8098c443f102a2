#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace rivage::core {

/// What the header of a .npy file says.
struct NpyHeader {
    int version = 1;
    std::string descr;  ///< e.g. "<u2"
    bool fortranOrder = false;
    std::vector<std::uint64_t> shape;
    std::size_t dataOffset = 0;  ///< bytes before the values
};

/// Parses the magic, the version and the dictionary of a .npy file.
/// @errors unsupportedFormat if the version is not 1, 2 or 3 or the values are structured;
///         malformedInput if the header ends early, is no such dictionary, or lacks a key
/// @source numpy.lib.format
Result<NpyHeader> parseNpyHeader(std::span<const std::byte> bytes);

}  // namespace rivage::core
