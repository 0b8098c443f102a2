#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/formats/label_volume.h"
#include "core/formats/volume_frame.h"

namespace rivage::core {

enum class NrrdEncoding : std::uint8_t { raw, gzip, text };

/// What the fields of 3D Slicer say about one value of a segmentation.
struct NrrdSegment {
    std::string name;
    std::optional<Rgba8> color;
    std::optional<std::uint32_t> value;
};

/// What the header of an NRRD file with a volume of labels says.
struct NrrdHeader {
    int version = 1;
    std::string typeName;
    ValueType type;
    Vec3i size = Vec3i::Ones();
    NrrdEncoding encoding = NrrdEncoding::raw;
    VolumeSteps steps{Vec3d::UnitX(), Vec3d::UnitY(), Vec3d::UnitZ()};
    std::uint64_t lineSkip = 0;  ///< lines before the values
    std::optional<std::uint64_t> byteSkip =
        0;  ///< bytes before the values; nothing: they come last
    std::map<std::uint32_t, NrrdSegment> segments;  ///< by their number in the file
    std::size_t dataOffset = 0;                     ///< bytes of the header
};

/// Parses an NRRD header, versions 1 to 6, that is attached to its values.
/// @errors unsupportedFormat for another version, dimension, type or encoding, a detached header, and
///         segments in several layers; malformedInput for a header that breaks off, lacks a field or
///         has one that says nothing
/// @source the NRRD format (Teem); the page on segmentations of 3D Slicer's developer guide
Result<NrrdHeader> parseNrrdHeader(std::span<const std::byte> bytes);

}  // namespace rivage::core
