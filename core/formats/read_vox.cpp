#include "core/formats/read_vox.h"

#include <bitset>
#include <string>
#include <utility>

#include "core/formats/vox_document.h"
#include "core/formats/vox_materials.h"
#include "core/formats/vox_nodes.h"
#include "core/formats/vox_scene_graph.h"

namespace rivage::core {
namespace {

// The store of a brick grid doubles when it is full, so up to twice its bricks are reserved.
constexpr std::uint64_t kStoreSlack = 2;
constexpr std::size_t kPoll = 1 << 16;  // voxels between two polls

struct StoredVoxel {
    Vec3i at;
    MaterialId material;
};

StoredVoxel voxelAt(std::span<const std::byte> voxels, std::size_t i) {
    const auto byte = [&](std::size_t k) { return std::to_integer<int>(voxels[4 * i + k]); };
    return {Vec3i(byte(0), byte(1), byte(2)), MaterialId{static_cast<std::uint16_t>(byte(3))}};
}

/// Checks every voxel against the model's size and predicts the bytes of its grid.
Result<std::uint64_t> checkModel(const VoxModel& model, std::size_t number, const RunContext& run) {
    std::bitset<16 * 16 * 16> touched;  // bricks of a model of 256^3
    for (std::size_t i = 0; i < model.voxels.size() / 4; ++i) {
        if (i % kPoll == 0 && run.stopped()) return fail(run.stopError());
        const StoredVoxel voxel = voxelAt(model.voxels, i);
        if ((voxel.at.array() >= model.size.array()).any())
            return voxError(
                "voxel " + std::to_string(i) + " at (" + std::to_string(voxel.at.x()) + ", " +
                    std::to_string(voxel.at.y()) + ", " + std::to_string(voxel.at.z()) +
                    ") lies outside its model of " + std::to_string(model.size.x()) + "x" +
                    std::to_string(model.size.y()) + "x" + std::to_string(model.size.z()),
                "/grid/models/" + std::to_string(number) + "/voxels");
        const Vec3i brick = voxel.at / BrickGrid::kSide;
        if (voxel.material != MaterialId{0})
            touched.set(brick.x() + std::size_t{16} * (brick.y() + std::size_t{16} * brick.z()));
    }
    const Vec3i bricks = (model.size.array() + (BrickGrid::kSide - 1)) / BrickGrid::kSide;
    return touched.count() * sizeof(BrickGrid::Brick) * kStoreSlack +
           static_cast<std::uint64_t>(bricks.prod()) * sizeof(std::uint32_t) + sizeof(BrickGrid);
}

Result<std::vector<BrickGrid>> buildModels(const VoxDocument& document, const RunContext& run) {
    std::uint64_t memory = 0;
    for (std::size_t m = 0; m < document.models.size(); ++m) {
        const Result<std::uint64_t> bytes = checkModel(document.models[m], m, run);
        if (!bytes) return fail(bytes.error());
        memory += *bytes;
        if (memory > run.limits.maxMemory)
            return fail(Error{
                ErrorCode::memoryBudget,
                "the models need more than " + std::to_string(run.limits.maxMemory) + " bytes",
                "/grid/models", run.limits.maxMemory, memory, "--memory-budget"});
    }
    std::vector<BrickGrid> models;
    models.reserve(document.models.size());
    for (const VoxModel& model : document.models) {
        if (run.stopped()) return fail(run.stopError());
        BrickGrid& grid = models.emplace_back(model.size);
        for (std::size_t i = 0; i < model.voxels.size() / 4; ++i) {
            if (i % kPoll == 0 && run.stopped()) return fail(run.stopError());
            const StoredVoxel voxel = voxelAt(model.voxels, i);
            grid.set(voxel.at, voxel.material);
        }
    }
    return models;
}

}  // namespace

Result<Scene> readVox(std::span<const std::byte> bytes, const InputOptions& options,
                      const RunContext& run) {
    const Result<VoxDocument> document = parseVoxDocument(bytes, options.frame, run.limits);
    if (!document) return fail(document.error());
    if (document->models.empty())
        return fail(ErrorCode::emptyGrid, "the file holds no model", "/grid/models");
    Result<std::vector<Instance>> instances = expandSceneGraph(*document, run.limits);
    if (!instances) return fail(std::move(instances.error()));
    Result<std::vector<BrickGrid>> models = buildModels(*document, run);
    if (!models) return fail(std::move(models.error()));

    Scene scene;
    scene.models = *std::move(models);
    scene.instances = *std::move(instances);
    scene.materials = voxMaterials(*document);
    scene.laterInstanceWins = document->version < 200;
    scene.format = GridFormat::vox;
    scene.formatDetail = "vox " + std::to_string(document->version);
    if (document->packed && *document->packed != document->models.size())
        scene.warnings.push_back("the PACK chunk announces " + std::to_string(*document->packed) +
                                 " models and the file has " +
                                 std::to_string(document->models.size()));
    return scene;
}

}  // namespace rivage::core
