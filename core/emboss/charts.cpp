#include "core/emboss/charts.h"

#include <algorithm>
#include <map>
#include <queue>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/union_find.h"

namespace rivage::core {
namespace {

using SurfelTiles = IdVector<SurfelId, SurfelTile>;

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }

/// How far v of one patch runs ahead of v of another along their border.
struct Border {
    double low = 1e300;
    double high = -1e300;
    double sum = 0;
    int count = 0;

    void add(double ahead) {
        low = std::min(low, ahead);
        high = std::max(high, ahead);
        sum += ahead;
        ++count;
    }
    /// Courses can continue only where the two run alike.
    [[nodiscard]] bool agrees() const { return high - low < 0.75; }
    [[nodiscard]] double mean() const { return sum / count; }
};

bool sameTile(const SurfelTile& a, const SurfelTile& b) {
    return a.face.tile == b.face.tile && a.face.ofOuter == b.face.ofOuter;
}

bool samePatch(const SurfelTile& a, const SurfelTile& b) {
    return sameTile(a, b) && a.frame == b.frame;
}

/// Patches of surfels with one frame and one tile, and where they border on each other.
class Patches {
public:
    Patches(const ChartInput& input, const SurfelTiles& tiles, const RunContext& run)
        : of_(tiles.size()) {
        UnionFind sets(tiles.size());
        forEachLink(input, tiles, run, [&](SurfelId s, SurfelId g, std::size_t) {
            if (samePatch(tiles[s], tiles[g])) sets.join(index(s), index(g));
        });
        serialFor(tiles.size(), run, [&](std::size_t i) {
            const SurfelId root{sets.find(static_cast<std::uint32_t>(i))};
            if (root == surfel(i)) first_.push_back(root);
            of_[surfel(i)] =
                root == surfel(i) ? static_cast<std::uint32_t>(first_.size() - 1) : of_[root];
        });
        forEachLink(input, tiles, run, [&](SurfelId s, SurfelId g, std::size_t edge) {
            if (of_[s] == of_[g] || !sameTile(tiles[s], tiles[g])) return;
            const auto& corners = input.surface.corners[s];
            const Vec3d middle =
                0.5 * (input.positions[corners[edge]] + input.positions[corners[(edge + 1) & 3U]]);
            const Vec3d at = middle + input.origin;
            borders_[{of_[s], of_[g]}].add((tiles[g].frame.v - tiles[s].frame.v).dot(at));
        });
    }

    /// What to add to v of each patch.
    [[nodiscard]] std::vector<double> shifts(const SurfelTiles& tiles, const RunContext& run) const;
    [[nodiscard]] std::uint32_t of(SurfelId s) const { return of_[s]; }

private:
    template <typename Visit>
    static void forEachLink(const ChartInput& input, const SurfelTiles& tiles,
                            const RunContext& run, const Visit& visit) {
        serialFor(tiles.size(), run, [&](std::size_t i) {
            const SurfelId s = surfel(i);
            if (!tiles[s].face.tile) return;
            for (std::size_t edge = 0; edge < 4; ++edge)
                if (const SurfelId g = input.links[s][edge]; g != kNone<SurfelId>)
                    visit(s, g, edge);
        });
    }

    IdVector<SurfelId, std::uint32_t> of_;
    std::vector<SurfelId> first_;  // the first surfel of each patch
    // From a patch to another; both directions are there.
    std::map<std::pair<std::uint32_t, std::uint32_t>, Border> borders_;
};

// Grows from what the world aligns to what it does not, over the longest borders first.
std::vector<double> Patches::shifts(const SurfelTiles& tiles, const RunContext& run) const {
    struct Step {
        int count;
        std::uint32_t to;
        double shift;
        bool operator<(const Step& other) const {
            return count != other.count ? count < other.count : to > other.to;
        }
    };
    std::vector<double> shift(first_.size(), 0);
    std::vector<std::uint8_t> placed(first_.size());
    std::priority_queue<Step> steps;
    const auto place = [&](std::uint32_t patch) {
        placed[patch] = 1;
        for (auto at = borders_.lower_bound({patch, 0});
             at != borders_.end() && at->first.first == patch; ++at)
            if (at->second.agrees() && placed[at->first.second] == 0)
                steps.push({at->second.count, at->first.second, shift[patch] - at->second.mean()});
    };
    serialFor(first_.size(), run, [&](std::size_t p) {
        if (!tiles[first_[p]].frame.slope) place(static_cast<std::uint32_t>(p));
    });
    while (!steps.empty() && !run.stopped()) {
        const Step step = steps.top();
        steps.pop();
        if (placed[step.to] != 0) continue;
        shift[step.to] = step.shift;
        place(step.to);
    }
    return shift;
}

}  // namespace

SurfelTiles placeTiles(const ChartInput& input, const TileChoice& choice, const RunContext& run) {
    SurfelTiles tiles(input.surface.surfelCount());
    (void)parallelFor(tiles.size(), run, [&](std::size_t i) {
        const SurfelId s = surfel(i);
        SurfelTile& tile = tiles[s];
        tile.face = choice.of(input.surface, s);
        if (tile.face.tile) tile.frame = tileFrame((tile.face.ofOuter ? -1 : 1) * input.normals[s]);
    });
    if (run.stopped()) return tiles;
    const Patches patches(input, tiles, run);
    if (run.stopped()) return tiles;
    const std::vector<double> shifts = patches.shifts(tiles, run);
    serialFor(tiles.size(), run,
              [&](std::size_t i) { tiles[surfel(i)].shiftV = shifts[patches.of(surfel(i))]; });
    return tiles;
}

}  // namespace rivage::core
