#include "core/voxelize/reduce_palette.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "core/base/parallel.h"
#include "core/base/vec.h"
#include "core/grid/oklab.h"

namespace rivage::core {
namespace {

constexpr int kRounds = 16;  // of k-means; later ones move colours by less than anyone sees

struct Color {
    MaterialId id;
    Vec3d lab;
    double weight;
};

/// Everything of a material but its colour, place and name.
using Look = std::tuple<MaterialClass, double, double, double, double, double, double, int>;

Look lookOf(const Material& m) {
    return {m.kind, m.roughness, m.metallic,         m.transmission,
            m.ior,  m.emission,  m.emissiveStrength, m.color[3]};
}

/// Colours begin .. end of a group, which one entry will stand for.
struct Cluster {
    std::size_t begin;
    std::size_t end;
    Vec3d mean = Vec3d::Zero();
    Vec3d spread = Vec3d::Zero();  ///< weighted sum of squares along each axis

    [[nodiscard]] double error() const { return end - begin < 2 ? 0 : spread.sum(); }
};

Cluster measured(const std::vector<Color>& colors, std::size_t begin, std::size_t end) {
    Cluster cluster{begin, end};
    double weight = 0;
    for (std::size_t i = begin; i < end; ++i) {
        cluster.mean += colors[i].weight * colors[i].lab;
        weight += colors[i].weight;
    }
    cluster.mean /= weight;
    for (std::size_t i = begin; i < end; ++i)
        cluster.spread += colors[i].weight * (colors[i].lab - cluster.mean).cwiseAbs2();
    return cluster;
}

/// Cuts the cluster with the largest error in two.
/// @return false if none has two colours that differ
bool cutWorst(std::vector<Color>& colors, std::vector<Cluster>& clusters) {
    const auto worst =
        std::max_element(clusters.begin(), clusters.end(),
                         [](const Cluster& a, const Cluster& b) { return a.error() < b.error(); });
    if (worst->error() <= 0) return false;
    int axis = 0;
    worst->spread.maxCoeff(&axis);
    const double at = worst->mean[axis];
    const auto first = colors.begin() + static_cast<std::ptrdiff_t>(worst->begin);
    const auto last = colors.begin() + static_cast<std::ptrdiff_t>(worst->end);
    const auto middle = std::stable_partition(
        first, last, [&](const Color& color) { return color.lab[axis] < at; });
    if (middle == first || middle == last) return false;
    const auto cut = static_cast<std::size_t>(middle - colors.begin());
    const Cluster high = measured(colors, cut, worst->end);
    *worst = measured(colors, worst->begin, cut);
    clusters.push_back(high);
    return true;
}

std::size_t nearestOf(const std::vector<Vec3d>& centres, const Vec3d& lab) {
    std::size_t nearest = 0;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < centres.size(); ++i)
        if (const double d = (centres[i] - lab).squaredNorm(); d < best) {
            best = d;
            nearest = i;
        }
    return nearest;
}

/// Moves the centres to the means of the colours that are nearest to them.
void settle(const std::vector<Color>& colors, std::vector<Vec3d>& centres, const RunContext& run) {
    for (int round = 0; round < kRounds && !run.stopped(); ++round) {
        std::vector<Vec3d> sums(centres.size(), Vec3d::Zero());
        std::vector<double> weights(centres.size(), 0);
        serialFor(
            colors.size(), run,
            [&](std::size_t i) {
                const std::size_t at = nearestOf(centres, colors[i].lab);
                sums[at] += colors[i].weight * colors[i].lab;
                weights[at] += colors[i].weight;
            },
            256);
        double moved = 0;
        for (std::size_t i = 0; i < centres.size(); ++i) {
            if (weights[i] <= 0) continue;
            moved = std::max(moved, (sums[i] / weights[i] - centres[i]).norm());
            centres[i] = sums[i] / weights[i];
        }
        if (moved < 1e-6) return;
    }
}

/// The colours of one look, and the parts of them that get an entry each.
struct Group {
    std::vector<Color> colors;
    std::vector<Cluster> clusters;
};

double worstError(const Group& group) {
    double error = 0;
    for (const Cluster& cluster : group.clusters) error = std::max(error, cluster.error());
    return error;
}

/// One cluster for each group, then the worst of all groups is cut until the entries are used up.
void shareEntries(std::map<Look, Group>& groups, std::size_t limit, const RunContext& run) {
    for (auto& [look, group] : groups)
        group.clusters = {measured(group.colors, 0, group.colors.size())};
    for (std::size_t used = groups.size(); used < limit && !run.stopped(); ++used) {
        const auto worst =
            std::max_element(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
                return worstError(a.second) < worstError(b.second);
            });
        if (!cutWorst(worst->second.colors, worst->second.clusters)) break;
    }
}

/// Adds the entries of one group.
void addEntries(const Group& group, const IdVector<MaterialId, Material>& old,
                ReducedPalette& palette, double& errorSum, const RunContext& run) {
    std::vector<Vec3d> centres;
    for (const Cluster& cluster : group.clusters) centres.push_back(cluster.mean);
    settle(group.colors, centres, run);
    std::vector<MaterialId> entryOf(centres.size(), MaterialId{0});
    for (const Color& color : group.colors) {
        const std::size_t at = nearestOf(centres, color.lab);
        if (entryOf[at] == MaterialId{0}) {
            Material entry = old[color.id];
            const std::uint8_t alpha = entry.color[3];
            entry.color = srgbOfOklab(centres[at]);
            entry.color[3] = alpha;
            entry.name.clear();
            entry.source = static_cast<std::uint32_t>(palette.materials.size());
            entryOf[at] = palette.materials.push_back(entry);
        }
        palette.newId[index(color.id)] = entryOf[at];
        const double error = (oklabOf(palette.materials[entryOf[at]].color) - color.lab).norm();
        palette.errorMax = std::max(palette.errorMax, error);
        errorSum += error * color.weight;
    }
}

/// All materials in use, each at its source where that is an entry of its own.
ReducedPalette keepAll(const IdVector<MaterialId, Material>& materials,
                       const std::vector<MaterialId>& used, std::size_t limit) {
    ReducedPalette palette;
    palette.newId.assign(materials.size(), MaterialId{0});
    palette.colors = used.size();
    std::set<std::uint32_t> sources;
    for (const MaterialId id : used) sources.insert(materials[id].source);
    const bool bySource = sources.size() == used.size() && !sources.empty() &&
                          *sources.begin() >= 1 && *sources.rbegin() <= limit;
    constexpr Rgba8 kUnused = {75, 75, 75, 255};
    for (const MaterialId id : used) {
        const std::size_t at = bySource ? materials[id].source : palette.materials.size();
        if (at >= palette.materials.size())
            palette.materials.resize(at + 1, Material{.color = kUnused});
        palette.materials.raw()[at] = materials[id];
        palette.newId[index(id)] = static_cast<MaterialId>(at);
    }
    return palette;
}

}  // namespace

std::vector<std::uint64_t> countByMaterial(const BrickGrid& voxels, std::size_t materials,
                                           const RunContext& run) {
    std::vector<std::uint64_t> counts(materials, 0);
    voxels.forEachUntil([&] { return run.stopped(); },
                        [&](const Vec3i&, MaterialId material) { ++counts[index(material)]; });
    return counts;
}

Result<ReducedPalette> reducePalette(const IdVector<MaterialId, Material>& materials,
                                     const std::vector<std::uint64_t>& voxels, std::size_t limit,
                                     const RunContext& run) {
    std::vector<MaterialId> used;
    for (std::size_t i = 1; i < materials.size(); ++i)
        if (voxels[i] > 0) used.push_back(static_cast<MaterialId>(i));
    if (used.size() <= limit) return keepAll(materials, used, limit);

    std::map<Look, Group> groups;
    double total = 0;
    for (const MaterialId id : used) {
        const Material& material = materials[id];
        const auto weight = static_cast<double>(voxels[index(id)]);
        groups[lookOf(material)].colors.push_back({id, oklabOf(material.color), weight});
        total += weight;
    }
    if (groups.size() > limit)
        return fail(Error{ErrorCode::tooManyLabels,
                          "the model has " + std::to_string(groups.size()) +
                              " materials that differ in more than colour, a .vox has " +
                              std::to_string(limit),
                          "/grid", limit, groups.size()});
    shareEntries(groups, limit, run);
    ReducedPalette palette;
    palette.reduced = true;
    palette.newId.assign(materials.size(), MaterialId{0});
    double errorSum = 0;
    for (const auto& [look, group] : groups) addEntries(group, materials, palette, errorSum, run);
    if (run.stopped()) return fail(run.stopError());
    palette.colors = palette.materials.size() - 1;
    palette.errorMean = errorSum / total;
    return palette;
}

}  // namespace rivage::core
