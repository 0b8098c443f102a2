#include "core/formats/read_npy.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/formats/clean_text.h"
#include "core/formats/label_volume.h"
#include "core/formats/npy_header.h"

namespace rivage::core {
namespace {

/// Byte order, kind and width, e.g. "<u2"; nothing for a type that holds no labels.
std::optional<ValueType> valueTypeOf(std::string_view descr) {
    constexpr std::string_view kTypes[] = {"b1", "u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8"};
    if (descr.size() != 3 || std::string_view("<>|=").find(descr[0]) == std::string_view::npos)
        return std::nullopt;
    if (std::find(std::begin(kTypes), std::end(kTypes), descr.substr(1)) == std::end(kTypes))
        return std::nullopt;
    const int bytes = descr[2] - '0';
    if (descr[0] == '|' && bytes != 1) return std::nullopt;
    return ValueType{.bytes = bytes,
                     .isSigned = descr[1] == 'i',
                     .bigEndian = descr[0] == '>',
                     .isBoolean = descr[1] == 'b'};
}

/// Voxels along x, y, z; huge ones are cut so that the check of the size refuses them.
Vec3i sizeOf(const NpyHeader& header) {
    Vec3i size;
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t entry = static_cast<std::size_t>(header.fortranOrder ? axis : 2 - axis);
        size[axis] = static_cast<int>(
            std::min<std::uint64_t>(header.shape[entry], std::numeric_limits<int>::max()));
    }
    return size;
}

}  // namespace

Result<Scene> readNpy(std::span<const std::byte> bytes, const RunContext& run) {
    const Result<NpyHeader> header = parseNpyHeader(bytes);
    if (!header) return fail(header.error());
    const std::optional<ValueType> type = valueTypeOf(header->descr);
    if (!type)
        return fail(ErrorCode::unsupportedFormat,
                    "arrays of type '" + cleanText(header->descr) +
                        "' are not supported: labels must be of type b1, u1 to u8 or i1 to i8",
                    "/grid/header/descr");
    if (header->shape.size() != 3)
        return fail(ErrorCode::unsupportedFormat,
                    "the array has " + std::to_string(header->shape.size()) +
                        " axes; a label grid has 3: [z][y][x] in C order",
                    "/grid/header/shape");
    const Vec3i size = sizeOf(*header);
    const Result<std::uint64_t> needed =
        checkVolumeSize(size, *type, run.limits, ErrorCode::malformedInput, "/grid/header/shape");
    if (!needed) return fail(needed.error());
    const std::size_t stored = bytes.size() - header->dataOffset;
    if (*needed != stored)
        return fail(Error{ErrorCode::malformedInput,
                          "the shape asks for " + std::to_string(*needed) +
                              " bytes of values and the file has " + std::to_string(stored),
                          "/grid", *needed, stored});
    Result<Scene> scene = sceneFromVolume(bytes.subspan(header->dataOffset), *type, size, run);
    if (!scene) return scene;
    scene->format = GridFormat::npy;
    scene->formatDetail = "npy " + std::to_string(header->version) + " " + header->descr;
    return scene;
}

}  // namespace rivage::core
