#include "core/formats/read_scene.h"
#include "core/grid/scene.h"
#include "tests/fuzz/check.h"

using namespace rivage;

/// The first byte chooses the options, the rest is a grid of any format.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    core::InputOptions options;
    options.labels = static_cast<core::LabelMode>((data[0] & 7) % 5);
    options.keepHidden = (data[0] & 8) != 0;
    options.frame = data[0] >> 4 & 3;
    if (data[0] >> 6 == 3) {
        options.format = core::GridFormat::raw;
        options.dims = core::Vec3i(4, 2, 3);
    }
    options.labelMap = {{"some", {1, 2, 3}}, {"other", {4}, (data[0] & 64) != 0}};
    const core::RunContext run = fuzz::smallRun();
    const auto scene = core::readScene(fuzz::asBytes(data + 1, size - 1), options, run);
    if (!scene) {
        fuzz::requireGoodError(scene.error());
        return 0;
    }
    const auto grid = core::mergeScene(*scene, options, run);
    if (!grid) {
        fuzz::requireGoodError(grid.error());
        return 0;
    }
    fuzz::require((grid->voxels.size().array() >= 1).all());
    fuzz::require(grid->voxels.countVoxels() > 0);
    grid->voxels.forEach([&](const core::Vec3i& voxel, core::MaterialId material) {
        fuzz::require(grid->voxels.contains(voxel));
        fuzz::require(core::index(material) < grid->materials.size());
        const core::Label label = grid->materials[material].label;
        fuzz::require(label != core::Label{0} && core::index(label) < grid->labels.size());
    });
    return 0;
}
