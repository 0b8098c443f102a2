#include "core/formats/write_vox.h"
#include "core/pipeline.h"
#include "core/samples/samples.h"

namespace rivage::core {

std::vector<std::string> sampleNames() {
    std::vector<std::string> names;
    for (const SampleInfo& info : sampleInfos()) names.emplace_back(info.name);
    return names;
}

Result<std::vector<std::byte>> sampleScene(const std::string& name) {
    const Result<Scene> scene = makeSample(name);
    if (!scene) return fail(scene.error());
    return writeVox(*scene);
}

}  // namespace rivage::core
