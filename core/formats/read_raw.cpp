#include "core/formats/read_raw.h"

#include <string>

#include "core/formats/label_volume.h"

namespace rivage::core {

Result<Scene> readRaw(std::span<const std::byte> bytes, const InputOptions& options,
                      const RunContext& run) {
    constexpr const char* kField = "/options/dims";
    if (!options.dims)
        return fail(ErrorCode::invalidOption, "the format raw needs dims, such as 64x68x40",
                    kField);
    const ValueType type{.bytes = options.rawType == RawType::u8 ? 1 : 2};
    const Result<std::uint64_t> needed =
        checkVolumeSize(*options.dims, type, run.limits, ErrorCode::invalidOption, kField);
    if (!needed) return fail(needed.error());
    if (*needed != bytes.size())
        return fail(Error{ErrorCode::malformedInput,
                          "dims and type ask for " + std::to_string(*needed) +
                              " bytes and the grid has " + std::to_string(bytes.size()),
                          "/grid", *needed, bytes.size()});
    Result<Scene> scene = sceneFromVolume(bytes, type, *options.dims, run);
    if (!scene) return scene;
    scene->format = GridFormat::raw;
    scene->formatDetail = options.rawType == RawType::u8 ? "raw u8" : "raw u16";
    return scene;
}

}  // namespace rivage::core
