#include "core/gltf/chunks.h"

#include <algorithm>
#include <numeric>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

// What a plane cuts off is a little more or less than was wanted: pieces are a tenth smaller than
// they may be, so that none has to be cut again.
constexpr std::size_t kSlack = 10;

/// The voxel in which the first vertex of a quad lies.
Vec3i placeOf(const MeshPrimitive& primitive, std::uint32_t quad) {
    return primitive.positions[primitive.quads[quad][0]].array().floor().cast<int>();
}

/// A plane across the longest side of a chunk with about `share` of its quads below.
struct Cut {
    int axis = 0;
    int from = 0;  ///< the first place above; equal to the lowest place if there is no such plane
    int lowest = 0;

    Cut(const MeshPrimitive& primitive, const Chunk& chunk, double share, const RunContext& run) {
        Vec3i low = placeOf(primitive, chunk[0]);
        Vec3i high = low;
        serialFor(chunk.size(), run, [&](std::size_t i) {
            const Vec3i place = placeOf(primitive, chunk[i]);
            low = low.cwiseMin(place);
            high = high.cwiseMax(place);
        });
        const int length = (high - low).maxCoeff(&axis);
        from = lowest = low[axis];
        std::vector<std::size_t> counts(static_cast<std::size_t>(length) + 1);
        serialFor(chunk.size(), run, [&](std::size_t i) {
            ++counts[static_cast<std::size_t>(placeOf(primitive, chunk[i])[axis] - lowest)];
        });
        const double wanted = share * static_cast<double>(chunk.size());
        std::size_t below = 0;
        while (from < high[axis] && (from == lowest || static_cast<double>(below) < wanted))
            below += counts[static_cast<std::size_t>(from++ - lowest)];
    }
};

/// The numbers that occur in `used`, ascending, each once.
std::vector<std::uint32_t> distinct(std::vector<std::uint32_t> used) {
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    return used;
}

std::uint32_t rankIn(const std::vector<std::uint32_t>& sorted, std::uint32_t value) {
    return static_cast<std::uint32_t>(std::lower_bound(sorted.begin(), sorted.end(), value) -
                                      sorted.begin());
}

}  // namespace

std::vector<Chunk> cutQuads(const MeshPrimitive& primitive, std::size_t most,
                            const RunContext& run) {
    std::vector<Chunk> done;
    Chunk all(primitive.quads.size());
    std::iota(all.begin(), all.end(), 0U);
    std::vector<Chunk> open{std::move(all)};
    while (!open.empty() && !run.stopped()) {
        Chunk chunk = std::move(open.back());
        open.pop_back();
        if (chunk.size() <= most) {
            done.push_back(std::move(chunk));
            continue;
        }
        const std::size_t pieces = chunk.size() / (most - most / kSlack) + 1;
        const std::size_t half = pieces / 2;
        const double share = static_cast<double>(half) / static_cast<double>(pieces);
        const Cut cut(primitive, chunk, share, run);
        Chunk low;
        Chunk high;
        serialFor(chunk.size(), run, [&](std::size_t i) {
            // Without a plane, which no surface needs, half of the quads.
            const bool above = cut.from > cut.lowest
                                   ? placeOf(primitive, chunk[i])[cut.axis] >= cut.from
                                   : i >= chunk.size() / 2;
            (above ? high : low).push_back(chunk[i]);
        });
        open.push_back(std::move(high));
        open.push_back(std::move(low));
    }
    return done;
}

MeshPrimitive chunkOf(const MeshPrimitive& primitive, std::span<const std::uint32_t> quads) {
    std::vector<std::uint32_t> used;
    for (const std::uint32_t q : quads)
        used.insert(used.end(), primitive.quads[q].begin(), primitive.quads[q].end());
    const std::vector<std::uint32_t> vertices = distinct(std::move(used));
    std::vector<std::uint32_t> standing;
    standing.reserve(vertices.size());
    for (const std::uint32_t v : vertices) standing.push_back(primitive.points[v]);
    const std::vector<std::uint32_t> points = distinct(standing);

    MeshPrimitive chunk;
    chunk.material = primitive.material;
    for (const std::uint32_t v : vertices) {
        chunk.positions.push_back(primitive.positions[v]);
        chunk.points.push_back(rankIn(points, primitive.points[v]));
        if (!primitive.normals.empty()) chunk.normals.push_back(primitive.normals[v]);
        if (!primitive.colors.empty()) chunk.colors.push_back(primitive.colors[v]);
    }
    for (const std::uint32_t q : quads) {
        Quad quad = primitive.quads[q];
        for (std::uint32_t& v : quad) v = rankIn(vertices, v);
        chunk.quads.push_back(quad);
    }
    return chunk;
}

}  // namespace rivage::core
