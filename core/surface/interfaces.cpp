#include "core/surface/interfaces.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

LabelPair pairOf(const VoxelGrid& grid, const DigitalSurface& surface, SurfelId s) {
    return {grid.materials[surface.innerMaterial[s]].label,
            grid.materials[surface.outerMaterial[s]].label};
}

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }

/// The label pairs that occur, ascending. Blocks keep their few pairs sorted, then they are united.
std::vector<LabelPair> findPairs(const VoxelGrid& grid, const DigitalSurface& surface,
                                 const RunContext& run) {
    constexpr std::size_t kBlock = 1 << 16;
    std::vector<std::vector<LabelPair>> found((surface.surfelCount() + kBlock - 1) / kBlock);
    parallelBlocks(surface.surfelCount(), kBlock, run, [&](std::size_t begin, std::size_t end) {
        auto& pairs = found[begin / kBlock];
        for (std::size_t s = begin; s < end; ++s) {
            const LabelPair pair = pairOf(grid, surface, surfel(s));
            if (!pairs.empty() && pairs.back() == pair) continue;
            pairs.push_back(pair);
        }
        std::sort(pairs.begin(), pairs.end());
        pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    });
    std::vector<LabelPair> all;
    for (const auto& pairs : found) all.insert(all.end(), pairs.begin(), pairs.end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
}

std::vector<std::uint64_t> countLabels(const VoxelGrid& grid, const RunContext& run) {
    std::vector<std::uint64_t> materials(grid.materials.size());
    grid.voxels.forEachUntil([&] { return run.stopped(); },
                             [&](const Vec3i&, MaterialId m) { ++materials[index(m)]; });
    std::vector<std::uint64_t> labels(grid.labels.size());
    for (std::size_t m = 0; m < materials.size(); ++m)
        labels[index(grid.materials.raw()[m].label)] += materials[m];
    return labels;
}

/// The side of a label pair that sheets are paired through, see `Interface::through`. The rule
/// depends on the voxels only, so that renaming the labels changes nothing.
void choosePairing(const std::vector<std::uint64_t>& voxels, Interface& patch) {
    const auto [inner, outer] = patch.labels;
    const bool outerHasMore = voxels[index(outer)] > voxels[index(inner)];
    patch.through = outer == Label{0} || outerHasMore ? outer : inner;
    patch.pairs = outer == Label{0} || voxels[index(outer)] != voxels[index(inner)];
}

}  // namespace

bool groupInterfaces(const VoxelGrid& grid, DigitalSurface& surface, const RunContext& run) {
    const std::vector<LabelPair> pairs = findPairs(grid, surface, run);
    const bool assigned = parallelFor(surface.surfelCount(), run, [&](std::size_t s) {
        const LabelPair pair = pairOf(grid, surface, surfel(s));
        const auto at = std::lower_bound(pairs.begin(), pairs.end(), pair) - pairs.begin();
        surface.interfaceOf[surfel(s)] = InterfaceId{static_cast<std::uint32_t>(at)};
    });
    if (!assigned) return false;

    const std::vector<std::uint64_t> voxels = countLabels(grid, run);
    surface.interfaces.resize(pairs.size());
    const bool counted = serialFor(surface.surfelCount(), run, [&](std::size_t s) {
        ++surface.interfaces[surface.interfaceOf[surfel(s)]].end;
    });
    if (!counted) return false;
    std::uint32_t begin = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        Interface& patch = surface.interfaces.raw()[i];
        patch.labels = pairs[i];
        choosePairing(voxels, patch);
        patch.begin = begin;
        begin += patch.end;
        patch.end = patch.begin;
    }
    surface.byInterface.resize(surface.surfelCount());
    return serialFor(surface.surfelCount(), run, [&](std::size_t s) {
        surface.byInterface[surface.interfaces[surface.interfaceOf[surfel(s)]].end++] = surfel(s);
    });
}

}  // namespace rivage::core
