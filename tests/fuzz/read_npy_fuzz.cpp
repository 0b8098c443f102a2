#include "core/formats/read_npy.h"
#include "tests/fuzz/check.h"

using namespace rivage;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto scene = core::readNpy(fuzz::asBytes(data, size), fuzz::smallRun());
    if (!scene) {
        fuzz::requireGoodError(scene.error());
        return 0;
    }
    fuzz::require(scene->models.size() == 1 && scene->models[0].countVoxels() > 0);
    scene->models[0].forEach([&](const core::Vec3i&, core::MaterialId material) {
        fuzz::require(core::index(material) < scene->materials.size());
    });
    return 0;
}
