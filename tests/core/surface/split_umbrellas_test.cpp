#include "core/surface/split_umbrellas.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "tests/support/grids.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

struct Split {
    DigitalSurface before;
    DigitalSurface surface;
    SurfelLinks links;
    std::size_t count = 0;
};

Split split(const VoxelGrid& grid, int threads = 1) {
    Split result;
    result.before = *extractSurface(grid, {.threads = threads});
    result.surface = result.before;
    result.links = *linkSurfels(result.surface, {.threads = threads});
    result.count = *splitUmbrellas(result.surface, result.links, {.threads = threads});
    return result;
}

VoxelGrid checkerboard() {
    return makeGrid({4, 4, 4}, 1, [](const Vec3i& v) { return v.sum() % 2; });
}

/// Two columns of voxels that share the linels between them.
VoxelGrid touchingColumns(int height) {
    return makeGrid({2, 2, height}, 1, [](const Vec3i& v) { return v.x() == v.y() ? 1 : 0; });
}

std::vector<VoxelGrid> noise() {
    std::vector<VoxelGrid> grids;
    for (std::uint32_t seed = 1; seed <= 24; ++seed)
        grids.push_back(randomGrid(seed, {6, 5, 7}, 1 + static_cast<int>(seed % 4)));
    grids.push_back(checkerboard());
    return grids;
}

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }
PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }
using Edge = std::pair<PointelId, PointelId>;

std::map<Edge, std::vector<SurfelId>> facesByEdge(const DigitalSurface& surface) {
    std::map<Edge, std::vector<SurfelId>> faces;
    for (std::size_t i = 0; i < surface.surfelCount(); ++i)
        for (int k = 0; k < 4; ++k) {
            const auto& corners = surface.corners[surfel(i)];
            faces[std::minmax(corners[k], corners[(k + 1) % 4])].push_back(surfel(i));
        }
    return faces;
}

int slotOf(const Vec3i& step) {
    for (int slot = 0; slot < kSlots; ++slot)
        if (step == Vec3i::Unit(slot / 2) * (slot % 2 ? 1 : -1)) return slot;
    return -1;
}

}  // namespace

TEST_SUITE_BEGIN("core/surface");

TEST_CASE("split: closed manifold surfaces stay as they are") {
    for (const VoxelGrid& grid : {ballGrid(12, 4.5), makeGrid({3, 2, 4}, 2, [](const Vec3i& v) {
                                      return v.x() < 2 ? 1 : 2;
                                  })}) {
        const Split result = split(grid);
        CHECK(result.count == 0);
        CHECK(result.surface.corners == result.before.corners);
        CHECK(result.surface.neighbours == result.before.neighbours);
    }
}

TEST_CASE("split: two voxels that share a corner become two cubes") {
    const Split result = split(makeGrid({2, 2, 2}, 1, [](const Vec3i& v) {
        return v == Vec3i(0, 0, 0) || v == Vec3i(1, 1, 1) ? 1 : 0;
    }));
    CHECK(result.count == 1);
    CHECK(result.surface.pointelCount() == 16);
    for (std::size_t i = 0; i < 16; ++i) {
        const auto& slots = result.surface.neighbours[pointel(i)];
        CHECK(std::count(slots.begin(), slots.end(), kNone<PointelId>) == 3);
        CHECK(isSplit(result.surface, pointel(i)) ==
              (result.surface.pointels[pointel(i)] == Vec3i(1, 1, 1)));
    }
}

TEST_CASE("split: columns that share linels part between the ends of the slit") {
    for (const int height : {1, 2, 5}) {
        const Split result = split(touchingColumns(height));
        CHECK(result.count == static_cast<std::size_t>(height - 1));
    }
    // The ends have two edges to the first copies, and no neighbour there.
    const Split result = split(touchingColumns(5));
    for (std::size_t i = 0; i < result.surface.pointelCount(); ++i) {
        const Vec3i& at = result.surface.pointels[pointel(i)];
        if (at.x() != 1 || at.y() != 1) continue;
        const auto& slots = result.surface.neighbours[pointel(i)];
        CHECK((slots[4] == kNone<PointelId>) == (at.z() <= 1 || at.z() == 5));
        CHECK((slots[5] == kNone<PointelId>) == (at.z() >= 4 || at.z() == 0));
    }
}

TEST_CASE("property: faces keep their places, copies stand together, in the order of pointels") {
    std::size_t all = 0;
    for (const VoxelGrid& grid : noise()) {
        const Split result = split(grid);
        all += result.count;
        for (std::size_t i = 0; i < result.surface.surfelCount(); ++i)
            for (int k = 0; k < 4; ++k)
                CHECK(result.surface.pointels[result.surface.corners[surfel(i)][k]] ==
                      result.before.pointels[result.before.corners[surfel(i)][k]]);
        std::set<std::tuple<int, int, int>> places;
        std::tuple<int, int, int> last{-1, -1, -1};
        for (const Vec3i& at : result.surface.pointels) {
            const std::tuple<int, int, int> key{at.z(), at.y(), at.x()};
            CHECK(last <= key);
            last = key;
            places.insert(key);
        }
        CHECK(places.size() == result.before.pointelCount());
    }
    CHECK(all > 300);
}

TEST_CASE("property: the boundary of every label is closed by pointels") {
    for (const VoxelGrid& grid : noise()) {
        const DigitalSurface surface = split(grid).surface;
        for (const auto& [edge, faces] : facesByEdge(surface)) {
            std::map<Label, int> times;
            for (const SurfelId s : faces) {
                const LabelPair labels = surface.interfaces[surface.interfaceOf[s]].labels;
                ++times[labels.inner];
                ++times[labels.outer];
            }
            for (const auto& [label, count] : times)
                if (label != Label{0}) CHECK(count % 2 == 0);
        }
    }
}

TEST_CASE("property: neighbours are the ends of edges, in both directions") {
    for (const VoxelGrid& grid : noise()) {
        const DigitalSurface surface = split(grid).surface;
        std::set<Edge> listed;
        for (std::size_t i = 0; i < surface.pointelCount(); ++i)
            for (int slot = 0; slot < kSlots; ++slot) {
                const PointelId q = surface.neighbours[pointel(i)][slot];
                if (q == kNone<PointelId>) {
                    CHECK((surface.junctionSlots[pointel(i)] >> slot & 1) == 0);
                    continue;
                }
                CHECK(surface.neighbours[q][slot ^ 1] == pointel(i));
                listed.insert(std::minmax(pointel(i), q));
            }
        const auto edges = facesByEdge(surface);
        std::map<std::pair<PointelId, int>, int> ends;
        for (const auto& [edge, faces] : edges) {
            const Vec3i step = surface.pointels[edge.second] - surface.pointels[edge.first];
            ++ends[{edge.first, slotOf(step)}];
            ++ends[{edge.second, slotOf(-step)}];
        }
        // Left out are exactly the edges that share an end and a direction with another.
        for (const auto& [edge, faces] : edges) {
            const Vec3i step = surface.pointels[edge.second] - surface.pointels[edge.first];
            const bool alone =
                ends[{edge.first, slotOf(step)}] == 1 && ends[{edge.second, slotOf(-step)}] == 1;
            CHECK(alone == (listed.count(edge) == 1));
        }
        for (const Edge& edge : listed) CHECK(edges.count(edge) == 1);
    }
}

TEST_CASE("property: interfaces that meet in a junction linel keep its pointels in common") {
    for (const VoxelGrid& grid : noise()) {
        const Split result = split(grid);
        std::set<Edge> junctions;
        for (std::size_t i = 0; i < result.surface.pointelCount(); ++i)
            for (int slot = 0; slot < kSlots; ++slot)
                if (result.surface.junctionSlots[pointel(i)] >> slot & 1)
                    junctions.insert(
                        std::minmax(pointel(i), result.surface.neighbours[pointel(i)][slot]));
        std::size_t expected = 0;
        for (const std::uint8_t slots : result.before.junctionSlots)
            expected += static_cast<std::size_t>(__builtin_popcount(slots & 0b101010U));
        CHECK(junctions.size() == expected);
    }
}

TEST_CASE("property: linked faces share the two pointels of their linel") {
    for (const VoxelGrid& grid : noise()) {
        const Split result = split(grid);
        for (std::size_t i = 0; i < result.surface.surfelCount(); ++i)
            for (int k = 0; k < 4; ++k) {
                const SurfelId g = result.links[surfel(i)][k];
                if (g == kNone<SurfelId>) continue;
                const auto& corners = result.surface.corners[surfel(i)];
                const auto& other = result.surface.corners[g];
                for (const PointelId p : {corners[k], corners[(k + 1) % 4]})
                    CHECK(std::count(other.begin(), other.end(), p) == 1);
            }
    }
}

TEST_CASE("determinism: threads 1, 2, 7 split alike") {
    const VoxelGrid grid = randomGrid(8, {21, 19, 23}, 3);
    const Split one = split(grid);
    for (const int threads : {2, 7}) {
        const Split other = split(grid, threads);
        CHECK(other.surface.pointels == one.surface.pointels);
        CHECK(other.surface.neighbours == one.surface.neighbours);
        CHECK(other.surface.corners == one.surface.corners);
        CHECK(other.surface.junctionSlots == one.surface.junctionSlots);
    }
}

TEST_CASE("reject: a cancelled split") {
    DigitalSurface surface = *extractSurface(checkerboard(), {});
    const SurfelLinks links = *linkSurfels(surface, {});
    const auto split = splitUmbrellas(surface, links, {.stopRequested = [] { return true; }});
    REQUIRE_FALSE(split);
    CHECK(split.error().code == ErrorCode::cancelled);
}

TEST_SUITE_END();
