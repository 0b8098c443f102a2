#include "core/formats/read_vox.h"
#include "core/formats/write_vox.h"
#include "tests/fuzz/check.h"

using namespace rivage;

/// A file that is read can be written, and what was written can be read again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto scene = core::readVox(fuzz::asBytes(data, size), {}, fuzz::smallRun());
    if (!scene) {
        fuzz::requireGoodError(scene.error());
        return 0;
    }
    for (const core::Instance& instance : scene->instances)
        for (const int model : instance.frames)
            fuzz::require(static_cast<std::size_t>(model) < scene->models.size());
    if (scene->instances.empty()) return 0;
    const auto written = core::writeVox(*scene);
    fuzz::require(written.has_value());
    const auto again = core::readVox(*written, {}, {});
    fuzz::require(again && again->models.size() == scene->models.size());
    fuzz::require(again->instances.size() == scene->instances.size());
    return 0;
}
