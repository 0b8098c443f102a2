#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

#include "core/grid/label_assignment.h"
#include "core/grid/scene.h"

namespace rivage::core {
namespace {

// The store of a brick grid doubles when it is full, so up to twice its bricks are reserved.
constexpr std::uint64_t kStoreSlack = 2;
// Stored cells of all instances together, empty ones and overlaps counted, per allowed voxel:
// bounds the time of a merge.
constexpr std::uint64_t kCellsPerVoxel = 16;

/// A box of cells, both ends included.
struct Box {
    Vec3i low;
    Vec3i high;
};

Box unite(const Box& a, const Box& b) { return {a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)}; }

/// The way of a cell of one placed model into the scene, in whole numbers.
///
/// The cube [c, c+1]^3 of a model is turned about the lattice point `pivot` and moved:
/// new = floor(R (c + 1/2 - pivot)) + translation. The centre c + 1/2 never lands on the lattice,
/// so a row of R that is +e_j gives c_j - pivot_j and one that is -e_j gives pivot_j - c_j - 1.
class Placement {
public:
    Placement(const Instance& instance, const Vec3i& size) {
        const Mat3i& rotation = instance.rotation;
        for (int row = 0; row < 3; ++row) {
            rotation.row(row).cwiseAbs().maxCoeff(&column_[row]);
            sign_[row] = rotation(row, column_[row]);
            const int side = size[column_[row]];
            // The low corner of the turned model is its cell 0 or, turned round, its last cell.
            const int shift = instance.centered ? (sign_[row] > 0 ? -(side / 2) : side / 2 - 1)
                                                : (sign_[row] > 0 ? 0 : side - 1);
            offset_[row] = shift + instance.translation[row];
        }
    }
    [[nodiscard]] bool isTranslation() const {
        return column_ == Vec3i(0, 1, 2) && sign_ == Vec3i::Ones();
    }
    [[nodiscard]] Vec3i apply(const Vec3i& cell) const {
        Vec3i placed;
        for (int row = 0; row < 3; ++row)
            placed[row] = sign_[row] * cell[column_[row]] + offset_[row];
        return placed;
    }
    [[nodiscard]] Box apply(const Box& box) const {
        const Vec3i a = apply(box.low);
        const Vec3i b = apply(box.high);
        return {a.cwiseMin(b), a.cwiseMax(b)};
    }

private:
    Vec3i column_ = Vec3i::Zero();
    Vec3i sign_ = Vec3i::Ones();
    Vec3i offset_ = Vec3i::Zero();
};

/// A model that is seen, and where.
struct Placed {
    const BrickGrid* model;
    Placement placement;
    int modelId;
};

int modelAt(const Instance& instance, int frame) {
    std::size_t key = 0;
    for (std::size_t k = 0; k < instance.frames.size(); ++k) {
        const int time = instance.frameTimes.empty() ? static_cast<int>(k) : instance.frameTimes[k];
        if (time <= frame) key = k;
    }
    return instance.frames[key];
}

/// The visible instances with the one that is seen where two overlap last.
std::vector<Placed> visibleInstances(const Scene& scene, const InputOptions& options) {
    std::vector<Placed> placed;
    for (const Instance& instance : scene.instances) {
        if (instance.frames.empty() || (instance.hidden && !options.keepHidden)) continue;
        const int model = modelAt(instance, options.frame);
        const BrickGrid& grid = scene.models[static_cast<std::size_t>(model)];
        placed.push_back({&grid, Placement(instance, grid.size()), model});
    }
    if (!scene.laterInstanceWins) std::reverse(placed.begin(), placed.end());
    return placed;
}

/// What is worth knowing of a model, found once and used by all its instances.
struct ModelFacts {
    std::optional<Box> box;   ///< of the voxels that are not empty
    std::uint64_t cells = 0;  ///< in stored bricks
    bool known = false;
};

/// Widens `box` by the voxels of one brick that are not empty.
void widenByBrick(const BrickGrid::Brick& brick, const Vec3i& base, std::optional<Box>& box) {
    constexpr int kSide = BrickGrid::kSide;
    for (int i = 0; i < static_cast<int>(BrickGrid::kBrickVoxels); ++i) {
        if (brick[static_cast<std::size_t>(i)] == MaterialId{0}) continue;
        const Vec3i voxel = base + Vec3i(i % kSide, i / kSide % kSide, i / kSide / kSide);
        box = box ? unite(*box, {voxel, voxel}) : Box{voxel, voxel};
    }
}

/// Means nothing once `run` asked to stop.
ModelFacts factsOf(const BrickGrid& model, const RunContext& run) {
    ModelFacts facts;
    facts.known = true;
    const Vec3i& bricks = model.bricks();
    for (int z = 0; z < bricks.z(); ++z)
        for (int y = 0; y < bricks.y(); ++y) {
            if (run.stopped()) return facts;
            for (int x = 0; x < bricks.x(); ++x) {
                const BrickGrid::Brick* brick = model.brick(Vec3i(x, y, z));
                if (!brick) continue;
                facts.cells += BrickGrid::kBrickVoxels;
                const Vec3i low = Vec3i(x, y, z) * BrickGrid::kSide;
                const Vec3i high = (low.array() + BrickGrid::kSide).min(model.size().array()) - 1;
                const bool inside = facts.box && (low.array() >= facts.box->low.array()).all() &&
                                    (high.array() <= facts.box->high.array()).all();
                if (!inside) widenByBrick(*brick, low, facts.box);
            }
        }
    return facts;
}

Error emptyError(const Scene& scene) {
    const bool hidden = std::any_of(scene.instances.begin(), scene.instances.end(),
                                    [](const Instance& instance) { return instance.hidden; });
    return {ErrorCode::emptyGrid,
            hidden ? "no voxel is left: the visible parts are empty, others are hidden"
                   : "the grid holds no voxel",
            "/grid"};
}

/// The bounding box of all placed voxels, with the limits that it must keep.
/// A volume with an open border is a cutout: the box is the whole of it, empty or not.
Result<Box> sceneBox(const Scene& scene, const std::vector<Placed>& placed, bool whole,
                     const RunContext& run) {
    std::vector<ModelFacts> facts(scene.models.size());
    std::optional<Box> box;
    std::uint64_t cells = 0;
    for (const Placed& part : placed) {
        if (run.stopped()) return fail(run.stopError());
        ModelFacts& fact = facts[static_cast<std::size_t>(part.modelId)];
        if (!fact.known) fact = factsOf(*part.model, run);
        if (!fact.box) continue;
        const Box all{Vec3i::Zero(), part.model->size() - Vec3i::Ones()};
        const Box own = part.placement.apply(whole ? all : *fact.box);
        box = box ? unite(*box, own) : own;
        cells += fact.cells;
    }
    if (run.stopped()) return fail(run.stopError());
    if (!box) return fail(emptyError(scene));
    const auto extent = static_cast<std::uint64_t>(
        (box->high.cast<std::int64_t>() - box->low.cast<std::int64_t>()).maxCoeff() + 1);
    if (extent > run.limits.maxExtent)
        return fail(Error{ErrorCode::tooLarge,
                          "the scene is " + std::to_string(extent) + " voxels long, at most " +
                              std::to_string(run.limits.maxExtent) + " are allowed",
                          "/grid", run.limits.maxExtent, extent, "--max-extent"});
    if (cells / kCellsPerVoxel > run.limits.maxVoxels)
        return fail(Error{
            ErrorCode::tooLarge,
            "the instances of the scene hold " + std::to_string(cells) + " cells, overlaps counted",
            "/grid", run.limits.maxVoxels * kCellsPerVoxel, cells, "--max-voxels"});
    return *box;
}

/// Refuses before the merged grid is filled what could not be held: marks the bricks that the
/// stored bricks of all parts can reach.
Result<void> checkMemory(const Scene& scene, const std::vector<Placed>& placed, const Box& box,
                         const RunContext& run) {
    constexpr int kSide = BrickGrid::kSide;
    const Vec3i bricks = (box.high - box.low).array() / kSide + 1;
    const auto count = static_cast<std::uint64_t>(bricks.x()) * bricks.y() * bricks.z();
    std::uint64_t memory = count * sizeof(std::uint32_t);
    for (const BrickGrid& model : scene.models) memory += model.memoryBytes();
    const auto budget = [&]() -> Result<void> {
        if (memory <= run.limits.maxMemory) return {};
        return fail(Error{
            ErrorCode::memoryBudget,
            "the merged grid needs more than " + std::to_string(run.limits.maxMemory) + " bytes",
            "/grid", run.limits.maxMemory, memory, "--memory-budget"});
    };
    if (Result<void> fits = budget(); !fits) return fits;

    std::vector<bool> reached(count, false);
    const auto markBox = [&](const Box& reach) {
        const Vec3i low = (reach.low.cwiseMax(box.low) - box.low) / kSide;
        const Vec3i high = (reach.high.cwiseMin(box.high) - box.low) / kSide;
        for (int z = low.z(); z <= high.z(); ++z)
            for (int y = low.y(); y <= high.y(); ++y)
                for (int x = low.x(); x <= high.x(); ++x) {
                    const std::size_t slot = x + static_cast<std::size_t>(bricks.x()) *
                                                     (y + static_cast<std::size_t>(bricks.y()) * z);
                    if (!reached[slot]) memory += sizeof(BrickGrid::Brick) * kStoreSlack;
                    reached[slot] = true;
                }
    };
    for (const Placed& part : placed) {
        const Vec3i& own = part.model->bricks();
        for (int z = 0; z < own.z(); ++z)
            for (int y = 0; y < own.y(); ++y) {
                if (run.stopped()) return fail(run.stopError());
                for (int x = 0; x < own.x(); ++x) {
                    if (!part.model->brick(Vec3i(x, y, z))) continue;
                    const Vec3i low = Vec3i(x, y, z) * kSide;
                    markBox(part.placement.apply(
                        Box{low, (low.array() + kSide).min(part.model->size().array()) - 1}));
                }
            }
    }
    return budget();
}

Result<BrickGrid> mergeVoxels(const std::vector<Placed>& placed, const Box& box,
                              const RunContext& run) {
    const Vec3i size = box.high - box.low + Vec3i::Ones();
    // A lone model that fills its box and is not turned, as from a volume, is copied as it is.
    const bool asIs = placed.size() == 1 && placed[0].model->size() == size &&
                      placed[0].placement.isTranslation();
    BrickGrid merged = asIs ? *placed[0].model : BrickGrid(size);
    for (const Placed& part : placed) {
        if (asIs) break;
        const auto put = [&](const Vec3i& voxel, MaterialId material) {
            merged.set(part.placement.apply(voxel) - box.low, material);
        };
        if (!part.model->forEachUntil([&] { return run.stopped(); }, put))
            return fail(run.stopError());
    }
    std::uint64_t voxels = 0;
    const auto count = [&](const Vec3i&, MaterialId) { ++voxels; };
    if (!merged.forEachUntil([&] { return run.stopped(); }, count)) return fail(run.stopError());
    if (voxels > run.limits.maxVoxels)
        return fail(Error{ErrorCode::tooLarge,
                          "the grid has " + std::to_string(voxels) + " voxels, at most " +
                              std::to_string(run.limits.maxVoxels) + " are allowed",
                          "/grid", run.limits.maxVoxels, voxels, "--max-voxels"});
    return merged;
}

/// Means nothing once `run` asked to stop.
std::vector<bool> usedMaterials(const BrickGrid& voxels, std::size_t materials,
                                const RunContext& run) {
    std::vector<bool> used(materials, false);
    voxels.forEachUntil([&] { return run.stopped(); },
                        [&](const Vec3i&, MaterialId material) { used[index(material)] = true; });
    return used;
}

/// The materials with a label, and the ids that the others are renamed to.
struct KeptMaterials {
    IdVector<MaterialId, Material> table{1};
    std::vector<MaterialId> newId;
    bool drops = false;  ///< a used material has no label, so voxels disappear
};

KeptMaterials keepLabelled(const IdVector<MaterialId, Material>& materials,
                           const std::vector<bool>& used) {
    KeptMaterials kept;
    kept.newId.assign(materials.size(), MaterialId{0});
    for (std::size_t i = 1; i < materials.size(); ++i) {
        if (!used[i]) continue;
        const Material& material = materials.raw()[i];
        if (material.label == Label{0})
            kept.drops = true;
        else
            kept.newId[i] = kept.table.push_back(material);
    }
    return kept;
}

/// The part of a grid inside its bounding box of voxels that keep a material; all of it where the
/// border is open, for there it is where the voxels ended and not where the regions do.
void cropToKept(VoxelGrid& grid, const RunContext& run) {
    const ModelFacts facts = factsOf(grid.voxels, run);
    if (!facts.box) {
        grid.voxels = BrickGrid();
        return;
    }
    const Vec3i size = facts.box->high - facts.box->low + Vec3i::Ones();
    if (size == grid.voxels.size() || grid.openBorder) return;
    BrickGrid cropped(size);
    const auto put = [&](const Vec3i& voxel, MaterialId material) {
        cropped.set(voxel - facts.box->low, material);
    };
    grid.voxels.forEachUntil([&] { return run.stopped(); }, put);
    grid.voxels = std::move(cropped);
    grid.origin += facts.box->low;
}

}  // namespace

Result<VoxelGrid> mergeScene(const Scene& scene, const InputOptions& options,
                             const RunContext& run) {
    const std::vector<Placed> placed = visibleInstances(scene, options);
    const bool open = options.border == Border::open;
    const bool whole = open && scene.format != GridFormat::vox;
    const Result<Box> box = sceneBox(scene, placed, whole, run);
    if (!box) return fail(box.error());
    if (const auto fits = checkMemory(scene, placed, *box, run); !fits) return fail(fits.error());
    Result<BrickGrid> merged = mergeVoxels(placed, *box, run);
    if (!merged) return fail(std::move(merged.error()));

    const std::vector<bool> used = usedMaterials(*merged, scene.materials.size(), run);
    const auto distinct = static_cast<std::uint64_t>(std::count(used.begin(), used.end(), true));
    if (distinct > run.limits.maxMaterials)
        return fail(Error{ErrorCode::tooManyLabels,
                          "the grid uses " + std::to_string(distinct) + " materials, at most " +
                              std::to_string(run.limits.maxMaterials) + " are allowed",
                          "/grid", run.limits.maxMaterials, distinct});
    IdVector<MaterialId, Material> materials = scene.materials;
    auto labels = assignLabels(materials, used, scene.format, options, run.limits);
    if (!labels) return fail(std::move(labels.error()));

    KeptMaterials kept = keepLabelled(materials, used);
    VoxelGrid grid;
    grid.voxels = *std::move(merged);
    grid.voxels.remap(kept.newId);
    grid.origin = box->low;
    grid.materials = std::move(kept.table);
    grid.labels = *std::move(labels);
    grid.openBorder = open;
    const Vec3d sides = options.spacing.value_or(scene.spacing);
    grid.spacing = sides / sides.minCoeff();
    if (kept.drops) cropToKept(grid, run);
    if (run.stopped()) return fail(run.stopError());
    if (grid.voxels.size() == Vec3i::Zero())
        return fail(ErrorCode::emptyGrid, "the label map takes no voxel of the grid",
                    "/options/labels");
    return grid;
}

}  // namespace rivage::core
