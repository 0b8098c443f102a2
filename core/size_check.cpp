#include "core/size_check.h"

#include <optional>

#include "core/voxel_output.h"

namespace rivage::core {
namespace {

/// What the pieces of an embossed surface add at their peak, above.
std::uint64_t embossMemory(const SurfaceSize& size, const EmbossOptions& emboss) {
    constexpr std::uint64_t kBytesPerSolvedPiece = 1200;
    constexpr std::uint64_t kBytesPerMovedPiece = 600;
    if (emboss.rules.empty()) return 0;
    const bool solved = emboss.method == EmbossMethod::normals;
    return (solved ? kBytesPerSolvedPiece : kBytesPerMovedPiece) * size.surfels *
           static_cast<std::uint64_t>(emboss.detail * emboss.detail);
}

std::optional<Error> aboveBudget(const VoxelGrid& grid, const SurfaceSize& size,
                                 const EmbossOptions& emboss, const Limits& limits) {
    const std::uint64_t memory = predictMemory(grid, size, emboss);
    if (memory <= limits.maxMemory) return std::nullopt;
    return Error{
        ErrorCode::memoryBudget,
        "the conversion of this grid would take more memory (bytes) than the budget of one "
        "conversion",
        "/grid",
        limits.maxMemory,
        memory,
        "--memory-budget"};
}

}  // namespace

std::uint64_t predictMemory(const VoxelGrid& grid, const SurfaceSize& size,
                            const EmbossOptions& emboss) {
    constexpr std::uint64_t kBytesPerSurfel = 1200;
    constexpr std::uint64_t kFixed = 16ULL << 20;
    // Extraction counts the cells of each row of pointels, empty or not.
    constexpr std::uint64_t kBytesPerRow = 16;
    const Vec3i& dims = grid.voxels.size();
    const std::uint64_t rows = (dims.y() + std::uint64_t{1}) * (dims.z() + std::uint64_t{1});
    return kFixed + grid.voxels.memoryBytes() + kBytesPerRow * rows +
           kBytesPerSurfel * size.surfels + embossMemory(size, emboss);
}

Result<SurfaceSize> checkSize(const VoxelGrid& grid, const ConversionOptions* options,
                              const RunContext& run) {
    const EmbossOptions emboss = options ? options->emboss : EmbossOptions{};
    if (const auto error = aboveBudget(grid, {}, emboss, run.limits)) return fail(*error);
    auto size = countSurface(grid, run);
    if (!size) return size;
    if (const auto error = aboveBudget(grid, *size, emboss, run.limits)) return fail(*error);
    if (!options || !isVoxels(options->output.format)) return size;
    const auto fits =
        checkVoxelOutput(grid, {size->surfels, predictMemory(grid, *size)}, options->output, run);
    if (!fits) return fail(fits.error());
    return size;
}

}  // namespace rivage::core
