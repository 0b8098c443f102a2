#include "core/formats/read_vol.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/formats/clean_text.h"
#include "core/formats/header_text.h"
#include "core/formats/inflate.h"
#include "core/formats/label_volume.h"

namespace rivage::core {
namespace {

constexpr std::size_t kMaxHeader = 4096;  // bytes
constexpr std::string_view kEnd = "\n.\n";

/// Key and value by line, and where the values of the volume begin.
struct VolHeader {
    std::map<std::string, std::string, std::less<>> fields;
    std::size_t bytes = 0;

    [[nodiscard]] std::optional<std::uint64_t> number(std::string_view key) const {
        const auto found = fields.find(key);
        return found == fields.end() ? std::nullopt : numberIn<std::uint64_t>(found->second);
    }
};

std::string_view headOf(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()),
                                std::min(bytes.size(), kMaxHeader));
    return text.substr(0, text.find(kEnd));
}

VolHeader readHeader(std::span<const std::byte> bytes) {
    std::string_view text = headOf(bytes);
    VolHeader header{.bytes = text.size() + kEnd.size()};
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        const std::size_t colon = line.find(':');
        if (colon == std::string_view::npos) continue;
        header.fields.insert_or_assign(std::string(trimmed(line.substr(0, colon))),
                                       trimmed(line.substr(colon + 1)));
    }
    return header;
}

Result<ValueType> typeOf(const VolHeader& header) {
    constexpr const char* kField = "/grid/header/Voxel-Size";
    const auto bytes = header.fields.contains("Lvoxel-Size") ? header.number("Lvoxel-Size")
                                                             : header.number("Voxel-Size");
    if (!bytes) return fail(ErrorCode::malformedInput, "the .vol header has no Voxel-Size", kField);
    if (*bytes != 1 && *bytes != 2 && *bytes != 4 && *bytes != 8)
        return fail(ErrorCode::unsupportedFormat,
                    "values of " + std::to_string(*bytes) + " bytes are not supported", kField);
    const auto order = header.fields.find("Int-Endian");
    const bool big =
        order != header.fields.end() && (order->second == "3210" || order->second == "1032");
    return ValueType{.bytes = static_cast<int>(*bytes), .bigEndian = big};
}

Result<Vec3i> sizeOf(const VolHeader& header) {
    constexpr std::string_view kKeys[] = {"X", "Y", "Z"};
    Vec3i size;
    for (int axis = 0; axis < 3; ++axis) {
        const auto side = header.number(kKeys[axis]);
        if (!side)
            return fail(ErrorCode::malformedInput, "the .vol header lacks X, Y or Z",
                        "/grid/header/" + std::string(kKeys[axis]));
        size[axis] =
            static_cast<int>(std::min<std::uint64_t>(*side, std::numeric_limits<int>::max()));
    }
    return size;
}

}  // namespace

bool isVol(std::span<const std::byte> bytes) {
    const std::string_view head = headOf(bytes);
    return head.size() + kEnd.size() <= std::min(bytes.size(), kMaxHeader) &&
           (head.find("\nVoxel-Size:") != std::string_view::npos ||
            head.find("\nLvoxel-Size:") != std::string_view::npos);
}

Result<Scene> readVol(std::span<const std::byte> bytes, const RunContext& run) {
    if (!isVol(bytes))
        return fail(ErrorCode::malformedInput,
                    "the file does not begin with a .vol header that a line with a dot ends",
                    "/grid");
    const VolHeader header = readHeader(bytes);
    const auto type = typeOf(header);
    if (!type) return fail(type.error());
    const auto size = sizeOf(header);
    if (!size) return fail(size.error());
    const auto needed =
        checkVolumeSize(*size, *type, run.limits, ErrorCode::malformedInput, "/grid/header/X");
    if (!needed) return fail(needed.error());

    const auto version = header.fields.find("Version");
    const std::string name = version == header.fields.end() ? "1" : version->second;
    if (name != "1" && name != "2" && name != "3")
        return fail(ErrorCode::unsupportedFormat,
                    ".vol version " + cleanText(name) + " is not supported; 1, 2 and 3 are",
                    "/grid/header/Version");
    // Without a version, the size stands there once more, in binary, and a line break.
    constexpr std::size_t kBinarySize = 3 * 4 + 1;
    const std::size_t start = header.bytes + (version == header.fields.end() ? kBinarySize : 0);
    std::span<const std::byte> values = bytes.subspan(std::min(start, bytes.size()));
    std::vector<std::byte> unpacked;
    if (name == "3") {
        auto inflated = inflateUpTo(values, *needed + 1, run);
        if (!inflated) return fail(inflated.error());
        unpacked = *std::move(inflated);
        values = unpacked;
    }
    if (values.size() != *needed)
        return fail(Error{ErrorCode::malformedInput,
                          "X, Y and Z ask for " + std::to_string(*needed) +
                              " bytes of values and the file has " +
                              (values.size() > *needed ? "more" : std::to_string(values.size())),
                          "/grid", *needed, values.size()});
    auto scene = sceneFromVolume(values, *type, *size, run);
    if (!scene) return scene;
    scene->format = GridFormat::vol;
    scene->formatDetail = "vol " + name;
    return scene;
}

}  // namespace rivage::core
