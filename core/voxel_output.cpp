#include "core/voxel_output.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/formats/write_nrrd.h"
#include "core/formats/write_vox.h"
#include "core/gltf/placement.h"
#include "core/voxelize/coarsen.h"
#include "core/voxelize/revoxelize.h"
#include "core/voxelize/voxel_scene.h"

namespace rivage::core {
namespace {

constexpr const char* kField = "/options/scale";
constexpr double kMillimetres = 1000;  // in a metre

std::string scaleText(const Scale& scale) {
    const std::string up = std::to_string(scale.up);
    return scale.down == 1 ? up : up + "/" + std::to_string(scale.down);
}

/// Bricks of the result that the voxels of a grid can reach while they move by less than half a
/// voxel; those that move further are counted when they have.
std::uint64_t countBricks(const VoxelGrid& grid, const Vec3i& size, const Scale& scale,
                          const RunContext& run) {
    const Vec3i bricks = (size + Vec3i::Constant(BrickGrid::kSide - 1)) / BrickGrid::kSide;
    std::vector<bool> reached(static_cast<std::size_t>(bricks.x()) * bricks.y() * bricks.z());
    Vec3i lastLow = Vec3i::Constant(-1);
    Vec3i lastHigh = lastLow;
    std::uint64_t count = 0;
    grid.voxels.forEachUntil(
        [&] { return run.stopped(); },
        [&](const Vec3i& voxel, MaterialId) {
            const Vec3i low =
                ((2 * voxel - Vec3i::Ones()) * scale.up / (2 * scale.down)).cwiseMax(0) /
                BrickGrid::kSide;
            const Vec3i high = ((2 * voxel + Vec3i::Constant(3)) * scale.up / (2 * scale.down))
                                   .cwiseMin(size - Vec3i::Ones()) /
                               BrickGrid::kSide;
            if (low == lastLow && high == lastHigh) return;
            lastLow = low;
            lastHigh = high;
            for (int z = low.z(); z <= high.z(); ++z)
                for (int y = low.y(); y <= high.y(); ++y)
                    for (int x = low.x(); x <= high.x(); ++x) {
                        const std::size_t slot =
                            x + static_cast<std::size_t>(bricks.x()) *
                                    (y + static_cast<std::size_t>(bricks.y()) * z);
                        count += reached[slot] ? 0 : 1;
                        reached[slot] = true;
                    }
        });
    return count;
}

/// Bytes that the voxels, their samples and the file take together.
std::uint64_t predictMemory(const VoxelGrid& grid, std::uint64_t surfels, std::uint64_t fileBytes,
                            const OutputOptions& output, const RunContext& run) {
    constexpr std::uint64_t kBytesPerSurfel = 32;    // snapped pointels, nearest faces, blocks
    constexpr std::uint64_t kBytesPerCrossing = 10;  // runs, the crossings of a few blocks
    constexpr std::uint64_t kBytesPerBlock = 1200;
    constexpr std::uint64_t kCopies = 2;   // a grid in tiles beside the whole; a file as it grows
    constexpr std::uint64_t kPacking = 8;  // labels of regions; where they are noise, the rest of
                                           // the conversion takes a thousand times as much
    const Scale& scale = output.scale;
    const Vec3i size = scaledSize(grid.voxels.size(), scale);
    const bool coarser = scale.up < scale.down;
    const SampleLattice lattice =
        coarser ? samplesFor(size, scale) : SampleLattice{scale.up, scale.down, size};
    const auto up = static_cast<std::uint64_t>(lattice.up);
    const auto down = static_cast<std::uint64_t>(lattice.down);
    const std::uint64_t crossings = surfels * up * up / (down * down) + surfels;
    const std::uint64_t blocks = (lattice.size.x() / ColumnBlock::kSide + std::uint64_t{1}) *
                                 (lattice.size.y() / ColumnBlock::kSide + std::uint64_t{1});
    const std::uint64_t bricks = countBricks(grid, size, scale, run);
    const bool packed =
        output.format == OutputFormat::nrrd && output.compression != Compression::none;
    if (packed) fileBytes /= kPacking;
    return kBytesPerSurfel * surfels + kBytesPerCrossing * crossings + kBytesPerBlock * blocks +
           kCopies * (bricks * sizeof(BrickGrid::Brick) + fileBytes);
}

Result<void> checkSides(const VoxelGrid& grid, const OutputOptions& output, const Limits& limits) {
    if (output.format == OutputFormat::vox && grid.spacing != Vec3d::Ones())
        return fail(ErrorCode::invalidOption,
                    "the voxels of a .vox are cubes, so output=vox needs equal sides in spacing; "
                    "output=nrrd keeps them",
                    "/options/spacing");
    const auto extent =
        static_cast<std::uint64_t>(scaledSize(grid.voxels.size(), output.scale).maxCoeff());
    if (extent <= limits.maxExtent) return {};
    return fail(Error{ErrorCode::tooLarge,
                      "at scale " + scaleText(output.scale) + " the result is " +
                          std::to_string(extent) + " voxels long, at most " +
                          std::to_string(limits.maxExtent) + " are allowed",
                      kField, limits.maxExtent, extent, "--max-extent"});
}

/// Bytes of the file, about.
std::uint64_t fileBytes(const VoxelGrid& grid, const OutputOptions& output, std::uint64_t voxels) {
    constexpr std::uint64_t kBytesPerVoxel = 4;  // of a .vox
    if (output.format == OutputFormat::vox) return kBytesPerVoxel * voxels;
    return nrrdVolumeBytes(scaledSize(grid.voxels.size(), output.scale), grid.labels.size() - 1);
}

VolumePlace volumePlace(const VoxelGrid& input, const OutputOptions& output) {
    Mesh box;
    box.boxMin = input.origin.cast<double>().cwiseProduct(input.spacing);
    box.boxMax = (input.origin + input.voxels.size()).cast<double>().cwiseProduct(input.spacing);
    const double unit = output.voxelSize * kMillimetres;
    VolumePlace place;
    place.spacing = unit * input.spacing * output.scale.down / output.scale.up;
    place.origin = unit * (box.boxMin - placementOf(box, output).pivot) + 0.5 * place.spacing;
    return place;
}

Result<std::vector<std::byte>> writeScene(VoxelGrid&& voxels, const RunContext& run,
                                          ConversionReport& report) {
    auto made = voxelScene(std::move(voxels), run);
    if (!made) return fail(made.error());
    report.voxels->colors = made->colors;
    report.voxels->models = made->scene.models.size();
    if (made->colorsReduced) report.voxels->paletteError = {made->errorMax, made->errorMean};
    report.warnings.insert(report.warnings.end(), made->scene.warnings.begin(),
                           made->scene.warnings.end());
    run.report(Stage::write, 0);
    return writeVox(made->scene);
}

}  // namespace

Result<void> checkVoxelOutput(const VoxelGrid& grid, const ConversionSize& conversion,
                              const OutputOptions& output, const RunContext& run) {
    const Limits& limits = run.limits;
    if (auto fits = checkSides(grid, output, limits); !fits) return fits;
    const double times = static_cast<double>(output.scale.up) / output.scale.down;
    const auto voxels = static_cast<std::uint64_t>(static_cast<double>(grid.voxels.countVoxels()) *
                                                   times * times * times);
    if (voxels > limits.maxVoxels)
        return fail(Error{ErrorCode::tooLarge,
                          "at scale " + scaleText(output.scale) + " the result has about " +
                              std::to_string(voxels) + " voxels, at most " +
                              std::to_string(limits.maxVoxels) + " are allowed",
                          kField, limits.maxVoxels, voxels, "--max-voxels"});
    const std::uint64_t bytes = fileBytes(grid, output, voxels);
    if (bytes > limits.maxOutputBytes)
        return fail(Error{ErrorCode::outputTooLarge,
                          "at scale " + scaleText(output.scale) + " the result has about " +
                              std::to_string(bytes) + " bytes, at most " +
                              std::to_string(limits.maxOutputBytes) + " are allowed",
                          kField, limits.maxOutputBytes, bytes});
    const std::uint64_t memory =
        conversion.memory + predictMemory(grid, conversion.surfels, bytes, output, run);
    if (run.stopped()) return fail(run.stopError());
    if (memory > limits.maxMemory)
        return fail(Error{ErrorCode::memoryBudget,
                          "at scale " + scaleText(output.scale) +
                              " this conversion would take more memory (bytes) than the budget of "
                              "one conversion",
                          kField, limits.maxMemory, memory, "--memory-budget"});
    return {};
}

Result<std::vector<std::byte>> writeVoxels(const VoxelGrid& grid, const DigitalSurface& surface,
                                           const IdVector<PointelId, Vec3d>& positions,
                                           const OutputOptions& output, const RunContext& run,
                                           ConversionReport& report) {
    run.report(Stage::mesh, 0);
    VoxelReport& voxels = report.voxels.emplace();
    voxels.scale = scaleText(output.scale);
    auto made = revoxelize(grid, surface, positions, output.scale, run, voxels);
    if (!made) return fail(made.error());
    voxels.voxels = made->voxels.countVoxels();
    if (voxels.voxels == 0)
        return fail(ErrorCode::emptyGrid,
                    "at scale " + scaleText(output.scale) + " no voxel of the model is left",
                    kField);
    const bool vox = output.format == OutputFormat::vox;
    voxels.colors = grid.labels.size() - 1;
    if (!vox) run.report(Stage::write, 0);
    auto bytes = vox ? writeScene(*std::move(made), run, report)
                     : writeNrrd(*made, volumePlace(grid, output),
                                 output.compression != Compression::none, run);
    if (!bytes) return bytes;
    if (bytes->size() > run.limits.maxOutputBytes)
        return fail(Error{ErrorCode::outputTooLarge,
                          "the result has " + std::to_string(bytes->size()) + " bytes, at most " +
                              std::to_string(run.limits.maxOutputBytes) + " are allowed",
                          kField, run.limits.maxOutputBytes, bytes->size()});
    return bytes;
}

}  // namespace rivage::core
