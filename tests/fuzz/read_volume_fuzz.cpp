#include "core/formats/read_scene.h"
#include "core/grid/scene.h"
#include "tests/fuzz/check.h"

using namespace rivage;

/// NRRD, NIfTI, .vol, and all of them packed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto scene = core::readScene(fuzz::asBytes(data, size), {}, fuzz::smallRun());
    if (!scene) {
        fuzz::requireGoodError(scene.error());
        return 0;
    }
    fuzz::require(!scene->models.empty());
    fuzz::require(scene->spacing.minCoeff() > 0 && scene->spacing.allFinite());
    for (const core::BrickGrid& model : scene->models)
        model.forEach([&](const core::Vec3i&, core::MaterialId material) {
            fuzz::require(core::index(material) < scene->materials.size());
        });
    return 0;
}
