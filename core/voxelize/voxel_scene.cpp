#include "core/voxelize/voxel_scene.h"

#include <algorithm>
#include <utility>

#include "core/voxelize/reduce_palette.h"

namespace rivage::core {
namespace {

constexpr int kModelSide = 256;
constexpr int kModelBricks = kModelSide / BrickGrid::kSide;
static_assert(kModelSide % BrickGrid::kSide == 0);
constexpr std::size_t kColors = 255;
// MagicaVoxel keeps voxels at coordinates -1000..999 only (ephtracy/voxel-model, issue 66).
constexpr int kWorldLow = -1000;
constexpr int kWorldHigh = 1000;

/// The bricks of one model, copied; none where all are empty.
BrickGrid cutOut(const BrickGrid& voxels, const Vec3i& firstBrick, const Vec3i& size) {
    const Vec3i bricks = (size + Vec3i::Constant(BrickGrid::kSide - 1)) / BrickGrid::kSide;
    std::vector<bool> stored;
    for (int z = 0; z < bricks.z(); ++z)
        for (int y = 0; y < bricks.y(); ++y)
            for (int x = 0; x < bricks.x(); ++x)
                stored.push_back(voxels.brick(firstBrick + Vec3i(x, y, z)) != nullptr);
    BrickGrid model(size, stored);
    for (int z = 0; z < bricks.z(); ++z)
        for (int y = 0; y < bricks.y(); ++y)
            for (int x = 0; x < bricks.x(); ++x)
                if (const auto* brick = voxels.brick(firstBrick + Vec3i(x, y, z)))
                    *model.brick({x, y, z}) = *brick;
    return model;
}

/// Where the grid stands: at its origin, along each axis, unless it would leave the world.
Vec3i placeInWorld(const VoxelGrid& grid) {
    Vec3i place = grid.origin;
    for (int axis = 0; axis < 3; ++axis) {
        const int size = grid.voxels.size()[axis];
        const std::int64_t end = std::int64_t{place[axis]} + size;
        if (place[axis] < kWorldLow || end > kWorldHigh) place[axis] = -(size / 2);
    }
    return place;
}

void addModel(Scene& scene, BrickGrid&& model, const Vec3i& at) {
    Instance instance;
    instance.frames = {static_cast<int>(scene.models.size())};
    instance.translation = at;
    instance.centered = false;
    instance.layer = 0;
    scene.models.push_back(std::move(model));
    scene.instances.push_back(std::move(instance));
}

/// Means nothing once `run` asked to stop.
void addTiles(Scene& scene, const BrickGrid& voxels, const Vec3i& place, const RunContext& run) {
    const Vec3i tiles = (voxels.size() + Vec3i::Constant(kModelSide - 1)) / kModelSide;
    for (int z = 0; z < tiles.z(); ++z)
        for (int y = 0; y < tiles.y(); ++y)
            for (int x = 0; x < tiles.x(); ++x) {
                if (run.stopped()) return;
                const Vec3i low = Vec3i(x, y, z) * kModelSide;
                const Vec3i size = (voxels.size() - low).cwiseMin(Vec3i::Constant(kModelSide));
                BrickGrid model = cutOut(voxels, Vec3i(x, y, z) * kModelBricks, size);
                if (model.countVoxels() > 0) addModel(scene, std::move(model), place + low);
            }
}

}  // namespace

Result<VoxelScene> voxelScene(VoxelGrid&& grid, const RunContext& run) {
    const auto counts = countByMaterial(grid.voxels, grid.materials.size(), run);
    auto palette = reducePalette(grid.materials, counts, kColors, run);
    if (!palette) return fail(palette.error());
    grid.voxels.remap(palette->newId);

    VoxelScene made{.colors = palette->colors,
                    .colorsReduced = palette->reduced,
                    .errorMax = palette->errorMax,
                    .errorMean = palette->errorMean};
    Scene& scene = made.scene;
    scene.materials = std::move(palette->materials);
    scene.format = GridFormat::vox;
    const Vec3i place = placeInWorld(grid);
    if (place != grid.origin)
        scene.warnings.push_back(
            "the model stands elsewhere than in the input: MagicaVoxel shows "
            "voxels at -1000 to 999 only");
    if (grid.voxels.size().maxCoeff() > kWorldHigh - kWorldLow)
        scene.warnings.push_back("the model is longer than 2000 voxels; MagicaVoxel shows no more");
    if (grid.voxels.size().maxCoeff() <= kModelSide)
        addModel(scene, std::move(grid.voxels), place);
    else
        addTiles(scene, grid.voxels, place, run);
    if (run.stopped()) return fail(run.stopError());
    return made;
}

}  // namespace rivage::core
