#include "core/formats/read_nrrd.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/formats/inflate.h"
#include "core/formats/label_volume.h"
#include "core/formats/nrrd_header.h"
#include "core/formats/volume_frame.h"

namespace rivage::core {
namespace {

tl::unexpected<Error> wrongCount(const char* what, std::uint64_t needed, std::uint64_t found) {
    return fail(Error{ErrorCode::malformedInput,
                      std::string("the sizes ask for ") + std::to_string(needed) + " " + what +
                          " and the file has " + (found > needed ? "more" : std::to_string(found)),
                      "/grid", needed, found});
}

/// The values of a volume as they are in memory: in the file itself, or unpacked.
struct Values {
    std::vector<std::byte> unpacked;
    std::span<const std::byte> bytes;
};

Result<std::span<const std::byte>> afterLines(std::span<const std::byte> bytes,
                                              std::uint64_t lines) {
    for (; lines > 0; --lines) {
        const auto end = std::find(bytes.begin(), bytes.end(), std::byte{'\n'});
        if (end == bytes.end())
            return fail(ErrorCode::malformedInput, "line skip goes beyond the end of the file",
                        "/grid/header/line skip");
        bytes = bytes.subspan(static_cast<std::size_t>(end - bytes.begin()) + 1);
    }
    return bytes;
}

Result<Values> rawValues(std::span<const std::byte> bytes, const NrrdHeader& header,
                         std::uint64_t needed) {
    const std::uint64_t skip =
        header.byteSkip.value_or(bytes.size() - std::min<std::uint64_t>(needed, bytes.size()));
    if (skip > bytes.size()) return wrongCount("bytes", needed, 0);
    bytes = bytes.subspan(static_cast<std::size_t>(skip));
    if (bytes.size() != needed) return wrongCount("bytes", needed, bytes.size());
    return Values{{}, bytes};
}

Result<Values> packedValues(std::span<const std::byte> bytes, const NrrdHeader& header,
                            std::uint64_t needed, const RunContext& run) {
    const std::uint64_t skip = header.byteSkip.value_or(0);
    if (skip > run.limits.maxInputBytes) return wrongCount("bytes", needed, 0);
    auto unpacked = inflateUpTo(bytes, skip + needed + 1, run);
    if (!unpacked) return fail(unpacked.error());
    if (unpacked->size() != skip + needed)
        return wrongCount("bytes", needed, unpacked->size() - std::min(skip, unpacked->size()));
    Values values{*std::move(unpacked), {}};
    values.bytes =
        std::span<const std::byte>(values.unpacked).subspan(static_cast<std::size_t>(skip));
    return values;
}

/// Numbers between blanks, line breaks and commas, as values of 4 bytes, least significant first.
Result<Values> textValues(std::span<const std::byte> bytes, std::uint64_t count,
                          const RunContext& run) {
    constexpr std::uint64_t kPoll = 1 << 16;
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    Values values;
    for (std::uint64_t found = 0;; ++found) {
        if (found % kPoll == 0 && run.stopped()) return fail(run.stopError());
        text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n,"), text.size()));
        if (text.empty()) {
            if (found != count) return wrongCount("numbers", count, found);
            return values;
        }
        if (found == count) return wrongCount("numbers", count, found + 1);
        std::uint32_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc{})
            return fail(ErrorCode::malformedInput,
                        "number " + std::to_string(found) +
                            " of the volume is no whole number from 0 to 4294967295",
                        "/grid");
        text.remove_prefix(static_cast<std::size_t>(end - text.data()));
        for (int i = 0; i < 4; ++i)
            values.unpacked.push_back(static_cast<std::byte>(value >> (8 * i) & 0xff));
    }
}

void nameMaterials(const NrrdHeader& header, Scene& scene) {
    std::map<std::uint32_t, const NrrdSegment*> byValue;
    for (const auto& [number, segment] : header.segments)
        byValue.emplace(segment.value.value_or(number + 1), &segment);
    for (Material& material : scene.materials.raw()) {
        const auto found = byValue.find(material.source);
        if (material.source == 0 || found == byValue.end()) continue;
        material.name = found->second->name;
        material.color = found->second->color.value_or(material.color);
    }
}

}  // namespace

Result<Scene> readNrrd(std::span<const std::byte> bytes, const RunContext& run) {
    const auto header = parseNrrdHeader(bytes);
    if (!header) return fail(header.error());
    const auto needed = checkVolumeSize(header->size, header->type, run.limits,
                                        ErrorCode::malformedInput, "/grid/header/sizes");
    if (!needed) return fail(needed.error());
    const auto data = afterLines(bytes.subspan(header->dataOffset), header->lineSkip);
    if (!data) return fail(data.error());
    ValueType type = header->type;
    Result<Values> values = Values{};
    switch (header->encoding) {
        case NrrdEncoding::raw: values = rawValues(*data, *header, *needed); break;
        case NrrdEncoding::gzip: values = packedValues(*data, *header, *needed, run); break;
        case NrrdEncoding::text:
            values = textValues(*data, *needed / static_cast<std::uint64_t>(type.bytes), run);
            if (values) values->bytes = values->unpacked;
            type = {.bytes = 4};
            break;
    }
    if (!values) return fail(values.error());
    Result<Scene> scene = sceneFromVolume(values->bytes, type, header->size, run);
    if (!scene) return scene;
    if (auto placed = placeVolume(*scene, header->steps, "/grid/header/space directions"); !placed)
        return fail(placed.error());
    nameMaterials(*header, *scene);
    scene->format = GridFormat::nrrd;
    scene->formatDetail = "nrrd " + std::to_string(header->version) + " " + header->typeName;
    return scene;
}

}  // namespace rivage::core
