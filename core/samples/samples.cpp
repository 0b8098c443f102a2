#include "core/samples/samples.h"

#include <utility>

#include "core/samples/sample_scenes.h"

namespace rivage::core {
namespace {

struct Sample {
    SampleInfo info;
    Scene (*make)();
};

constexpr Sample kSamples[] = {
    {{"island", "An island in the sea: two labels, three interfaces", LabelMode::automatic},
     makeIsland},
    {{"sphere", "A ball of radius 12.3", LabelMode::automatic}, makeSphere},
    {{"torus", "A torus around the z axis", LabelMode::automatic}, makeTorus},
    {{"rotated_box", "A box with no face along the grid", LabelMode::automatic}, makeRotatedBox},
    {{"balls", "Three touching balls with a label each", LabelMode::automatic}, makeBalls},
    {{"foam", "A ball of Voronoi cells, one palette entry a cell", LabelMode::palette}, makeFoam},
    {{"house", "A house with a pitched roof, a door, windows and a chimney", LabelMode::automatic},
     makeHouse},
    {{"barn", "A barn with a barrel roof and a round tower, for relief", LabelMode::automatic},
     makeBarn},
    {{"checkerboard", "A cube where every second voxel is set", LabelMode::automatic},
     makeCheckerboard},
    {{"voxel", "A lone voxel", LabelMode::automatic}, makeVoxel},
};

}  // namespace

const std::vector<SampleInfo>& sampleInfos() {
    static const std::vector<SampleInfo> infos = [] {
        std::vector<SampleInfo> all;
        for (const Sample& sample : kSamples) all.push_back(sample.info);
        return all;
    }();
    return infos;
}

Result<Scene> makeSample(const std::string& name) {
    for (const Sample& sample : kSamples)
        if (sample.info.name == name) return sample.make();
    std::string message = "there is no sample '" + name + "'; there are";
    for (const Sample& sample : kSamples) message += " " + std::string(sample.info.name);
    return fail(ErrorCode::notFound, std::move(message));
}

Scene emptySample(const Vec3i& size, const std::string& name) {
    Scene scene;
    scene.models.emplace_back(size);
    scene.instances.push_back(
        {.frames = {0}, .translation = Vec3i(0, 0, size.z() / 2), .name = name});
    scene.laterInstanceWins = false;
    scene.format = GridFormat::vox;
    scene.formatDetail = "sample " + name;
    return scene;
}

MaterialId addPaletteRow(Scene& scene, const Material& like, std::initializer_list<Rgba8> colors) {
    while (scene.materials.size() % kPaletteRow != 1) {
        scene.materials.push_back(Material{});
        scene.materials.raw().back().source =
            static_cast<std::uint32_t>(scene.materials.size() - 1);
    }
    const auto first = static_cast<std::uint16_t>(scene.materials.size());
    for (const Rgba8& color : colors) {
        Material material = like;
        material.color = color;
        material.source = static_cast<std::uint32_t>(scene.materials.size());
        scene.materials.push_back(std::move(material));
    }
    return MaterialId{first};
}

std::uint32_t hashCell(int x, int y, int z, std::uint32_t seed) {
    std::uint32_t h = seed * 0x9e3779b9U;
    for (const int c : {x, y, z}) {
        h ^= static_cast<std::uint32_t>(c) + 0x7f4a7c15U + (h << 6) + (h >> 2);
        h *= 0x85ebca6bU;
        h ^= h >> 15;
    }
    h *= 0xc2b2ae35U;
    return h ^ h >> 16;
}

}  // namespace rivage::core
