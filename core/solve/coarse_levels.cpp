#include "core/solve/coarse_levels.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/base/union_find.h"

namespace rivage::core {
namespace {

constexpr std::size_t kBlock = 4096;

/// A linel, or all that is left of it on a coarser level: its two ends and how it couples them.
struct Edge {
    std::uint32_t a;
    std::uint32_t b;
    Symmetric3 block;
};

/// The linels with their alignment, and with a fairness that couples the ends of each linel as
/// strongly as the true one, which couples more pointels, does across a straight border.
std::vector<Edge> listEdges(const Energy& energy, const FloatOperator& operation,
                            const RunContext& run) {
    const DigitalSurface& surface = energy.surface();
    std::vector<Symmetric3> blocks(3 * energy.size(), Symmetric3{});
    for (std::size_t f = 0; f < surface.surfelCount(); ++f) {
        const SurfelId s{static_cast<std::uint32_t>(f)};
        const auto& corners = surface.corners[s];
        if (f % kBlock == 0 && run.stopped()) return {};
        for (int k = 0; k < 4; ++k) {
            const auto [low, high] = std::minmax(corners[k], corners[(k + 1) % 4]);
            const auto& ends = surface.neighbours[low];
            const int axis = ends[1] == high ? 0 : ends[3] == high ? 1 : 2;
            addSquare(blocks[3 * index(low) + axis], operation.scaledNormals()[s].lanes, 1);
        }
    }
    std::vector<Edge> edges;
    edges.reserve(2 * energy.size() + energy.size() / 8);
    const auto couple = [&](Symmetric3& block, PointelId i, int slot) {
        if ((energy.fairnessSlots(i) >> slot & 1) == 0) return;
        block.diagonal += operation.fairness()[i].diagonal;
        block.beside += operation.fairness()[i].beside;
    };
    for (std::uint32_t n = 0; n < energy.size(); ++n) {
        if (n % kBlock == 0 && run.stopped()) return {};
        for (int slot = 1; slot < kSlots; slot += 2) {
            const PointelId i{n};
            const PointelId j = surface.neighbours[i][slot];
            if (j == kNone<PointelId>) continue;
            Symmetric3& block = blocks[3 * std::size_t{n} + slot / 2];
            couple(block, i, slot);
            couple(block, j, slot ^ 1);
            edges.push_back({n, index(j), block});
        }
    }
    return edges;
}

}  // namespace

/// The pieces of one level: where they are and how they hang together.
struct CoarseLevels::Graph {
    std::vector<std::array<int, 3>> boxes;
    std::vector<float> alpha;
    std::vector<Edge> edges;
};

CoarseLevels::CoarseLevels(const Energy& energy, const FloatOperator& operation,
                           const RunContext& run)
    : workers_(energy.workers()) {
    constexpr std::size_t kFewest = 8;  // pieces; a coarser level would add nothing
    if (run.stopped()) return;
    Graph graph{{}, {}, listEdges(energy, operation, run)};
    serialFor(energy.size(), run, [&](std::size_t n) {
        const Vec3i& at = energy.surface().pointels.raw()[n];
        graph.boxes.push_back({at.x(), at.y(), at.z()});
        graph.alpha.push_back(static_cast<float>(energy.weights().alpha.raw()[n]));
    });
    if (run.stopped()) return;
    while (graph.boxes.size() > kFewest && !graph.edges.empty() && !workers_.stopped())
        addLevel(graph);
}

void CoarseLevels::addLevel(Graph& graph) {
    const std::size_t count = graph.boxes.size();
    for (auto& box : graph.boxes)
        for (int& side : box) side >>= 1;
    UnionFind sets(count);
    serialFor(graph.edges.size(), workers_, [&](std::size_t i) {
        const Edge& e = graph.edges[i];
        if (graph.boxes[e.a] == graph.boxes[e.b]) sets.join(e.a, e.b);
    });

    Level level;
    Graph above;
    level.parent.resize(count);
    level.start.assign(1, 0);
    std::vector<std::uint32_t> sizes;
    serialFor(count, workers_, [&](std::size_t k) {
        const auto i = static_cast<std::uint32_t>(k);
        const std::uint32_t first = sets.find(i);
        if (first == i) {
            level.parent[i] = static_cast<std::uint32_t>(above.boxes.size());
            above.boxes.push_back(graph.boxes[i]);
            above.alpha.push_back(0);
            sizes.push_back(0);
        }
        const std::uint32_t piece = level.parent[i] = level.parent[first];
        above.alpha[piece] += graph.alpha[i];
        ++sizes[piece];
    });
    // A level that lacks members would lead astray whoever still uses it.
    if (workers_.stopped()) return;
    for (const std::uint32_t size : sizes) level.start.push_back(level.start.back() + size);
    level.members.resize(count);
    std::vector<std::uint32_t> next(level.start.begin(), level.start.end() - 1);
    serialFor(count, workers_, [&](std::size_t i) {
        level.members[next[level.parent[i]]++] = static_cast<std::uint32_t>(i);
    });

    for (const float alpha : above.alpha)
        level.inverse.push_back({Lanes{alpha, alpha, alpha, 0}, Lanes{}});
    serialFor(graph.edges.size(), workers_, [&](std::size_t i) {
        const Edge& e = graph.edges[i];
        const Edge lifted{level.parent[e.a], level.parent[e.b], e.block};
        if (lifted.a == lifted.b) return;
        for (const std::uint32_t end : {lifted.a, lifted.b}) {
            level.inverse[end].diagonal += e.block.diagonal;
            level.inverse[end].beside += e.block.beside;
        }
        above.edges.push_back(lifted);
    });
    for (Symmetric3& block : level.inverse) block = inverseOf(block);
    level.sum.resize(above.boxes.size());
    level.correction.resize(above.boxes.size());
    levels_.push_back(std::move(level));
    graph = std::move(above);
}

double CoarseLevels::solve(const FloatVectors& r) {
    const std::vector<Float4>* below = &r.raw();
    for (Level& level : levels_) {
        parallelBlocks(level.sum.size(), kBlock, workers_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Lanes sum{};
                for (std::uint32_t m = level.start[i]; m < level.start[i + 1]; ++m)
                    sum += (*below)[level.members[m]].lanes;
                level.sum[i].lanes = sum;
            }
        });
        below = &level.sum;
    }
    // Down: the correction of a piece is its own and that of the piece it belongs to.
    double inner = 0;
    for (std::size_t l = levels_.size(); l-- > 0;) {
        Level& level = levels_[l];
        const Level* above = l + 1 < levels_.size() ? &levels_[l + 1] : nullptr;
        inner =
            blockedSum(level.sum.size(), workers_, 0.0, [&](std::size_t begin, std::size_t end) {
                double partial = 0;
                for (std::size_t i = begin; i < end; ++i) {
                    Lanes c = product(level.inverse[i], level.sum[i].lanes);
                    if (above != nullptr) c += above->correction[above->parent[i]].lanes;
                    level.correction[i].lanes = c;
                    const Lanes term = c * level.sum[i].lanes;
                    partial += double{term[0]} + double{term[1]} + double{term[2]};
                }
                return partial;
            });
    }
    return inner;
}

}  // namespace rivage::core
