#include <doctest/doctest.h>

#include <chrono>
#include <map>
#include <set>
#include <tuple>

#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"
#include "tests/support/grids.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

using Key = std::tuple<int, int, int>;
Key key(const Vec3i& p) { return {p.z(), p.y(), p.x()}; }

/// A surfel as the slow way finds it: its two voxels, and its corners in order.
struct PlainSurfel {
    Vec3i inner;
    Vec3i outer;
    std::array<Vec3i, 4> corners;
};

/// Every pair of face-adjacent voxels with different labels, the obvious way, sorted by
/// (z, y, x, axis) of the high voxel.
std::vector<PlainSurfel> slowSurface(const VoxelGrid& grid) {
    std::vector<PlainSurfel> surfels;
    const Vec3i size = grid.voxels.size();
    for (int z = 0; z <= size.z(); ++z)
        for (int y = 0; y <= size.y(); ++y)
            for (int x = 0; x <= size.x(); ++x)
                for (int axis = 0; axis < 3; ++axis) {
                    const Vec3i high(x, y, z);
                    const Vec3i low = high - Vec3i::Unit(axis);
                    const Label a = grid.labelAt(low);
                    const Label b = grid.labelAt(high);
                    if (a == b) continue;
                    const bool lowIsInner = b == Label{0} || (a != Label{0} && a < b);
                    Vec3i u = Vec3i::Unit((axis + 1) % 3);
                    Vec3i w = Vec3i::Unit((axis + 2) % 3);
                    if (!lowIsInner) std::swap(u, w);
                    surfels.push_back({lowIsInner ? low : high,
                                       lowIsInner ? high : low,
                                       {high, high + u, high + u + w, high + w}});
                }
    return surfels;
}

VoxelGrid checkerboard() {
    return makeGrid({4, 4, 4}, 1, [](const Vec3i& v) { return v.sum() % 2; });
}

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }
PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }

void checkAgainstSlow(const VoxelGrid& grid) {
    const auto surface = extractSurface(grid, {});
    REQUIRE(surface);
    const auto slow = slowSurface(grid);
    REQUIRE(surface->surfelCount() == slow.size());
    std::set<Key> pointels;
    for (std::size_t i = 0; i < slow.size(); ++i) {
        CHECK(surface->innerVoxel(surfel(i)) == slow[i].inner);
        CHECK(surface->outerVoxel(surfel(i)) == slow[i].outer);
        CHECK(surface->innerMaterial[surfel(i)] == grid.voxels.at(slow[i].inner));
        CHECK(surface->outerMaterial[surfel(i)] == grid.voxels.at(slow[i].outer));
        CHECK(surface->trivialNormal(surfel(i)) == slow[i].outer - slow[i].inner);
        for (int k = 0; k < 4; ++k) {
            CHECK(surface->pointels[surface->corners[surfel(i)][k]] == slow[i].corners[k]);
            pointels.insert(key(slow[i].corners[k]));
        }
    }
    REQUIRE(surface->pointelCount() == pointels.size());
    std::size_t i = 0;
    for (const Key& expected : pointels) CHECK(key(surface->pointels[pointel(i++)]) == expected);
}

}  // namespace

TEST_SUITE("core/surface") {
    TEST_CASE("differential: random grids give the surface of the slow way") {
        for (std::uint32_t seed = 1; seed <= 20; ++seed) {
            CAPTURE(seed);
            checkAgainstSlow(randomGrid(seed, {5, 6, 4}, 1 + static_cast<int>(seed % 4)));
        }
        checkAgainstSlow(randomGrid(77, {35, 3, 18}, 3));  // several bricks
        checkAgainstSlow(checkerboard());
        checkAgainstSlow(ballGrid(20, 8));
    }

    TEST_CASE("neighbours: a slot is filled exactly where a linel bounds a surfel") {
        const auto surface = extractSurface(randomGrid(5, {6, 5, 7}, 3), {});
        REQUIRE(surface);
        std::set<std::pair<std::uint32_t, std::uint32_t>> linels;
        for (const auto& corners : surface->corners)
            for (int k = 0; k < 4; ++k) {
                linels.insert({index(corners[k]), index(corners[(k + 1) % 4])});
                linels.insert({index(corners[(k + 1) % 4]), index(corners[k])});
            }
        std::size_t filled = 0;
        for (std::size_t i = 0; i < surface->pointelCount(); ++i)
            for (int slot = 0; slot < kSlots; ++slot) {
                const PointelId j = surface->neighbours[pointel(i)][slot];
                if (j == kNone<PointelId>) continue;
                ++filled;
                CHECK(linels.count({static_cast<std::uint32_t>(i), index(j)}) == 1);
                CHECK(surface->pointels[j] - surface->pointels[pointel(i)] ==
                      Vec3i::Unit(slot / 2) * (slot % 2 ? 1 : -1));
            }
        CHECK(filled == linels.size());
    }

    TEST_CASE("empty grid: no surface at all") {
        const auto surface =
            extractSurface(makeGrid({3, 3, 3}, 1, [](const Vec3i&) { return 0; }), {});
        REQUIRE(surface);
        CHECK(surface->surfelCount() == 0);
        CHECK(surface->pointelCount() == 0);
        CHECK(surface->interfaces.empty());
    }

    TEST_CASE("one voxel: a cube of 6 surfels, 8 pointels, no junction") {
        const auto surface =
            extractSurface(makeGrid({1, 1, 1}, 1, [](const Vec3i&) { return 1; }), {});
        REQUIRE(surface);
        CHECK(surface->surfelCount() == 6);
        CHECK(surface->pointelCount() == 8);
        REQUIRE(surface->interfaces.size() == 1);
        const LabelPair pair = surface->interfaces[InterfaceId{0}].labels;
        CHECK(pair == LabelPair{Label{1}, Label{0}});
        for (const std::uint8_t slots : surface->junctionSlots) CHECK(slots == 0);
    }

    TEST_CASE("junctions: two labels side by side meet the background along a square") {
        const auto surface = extractSurface(
            makeGrid({4, 2, 2}, 2, [](const Vec3i& v) { return v.x() < 2 ? 1 : 2; }), {});
        REQUIRE(surface);
        REQUIRE(surface->interfaces.size() == 3);
        int curve = 0;
        for (std::size_t i = 0; i < surface->pointelCount(); ++i) {
            const PointelId p = pointel(i);
            if (surface->junctionSlots[p] != 0) {
                ++curve;
                CHECK(surface->pointels[p].x() == 2);
                CHECK_FALSE(surface->isJunctionPointel(p));
            }
        }
        CHECK(curve == 8);
        CHECK(surface->interfaces[InterfaceId{1}].labels == LabelPair{Label{1}, Label{2}});
    }

    TEST_CASE("junctions: four labels in a row of quarters end in junction pointels") {
        const auto surface = extractSurface(
            makeGrid({2, 2, 1}, 4, [](const Vec3i& v) { return 1 + v.x() + 2 * v.y(); }), {});
        REQUIRE(surface);
        int ends = 0;
        for (std::size_t i = 0; i < surface->pointelCount(); ++i)
            ends += surface->isJunctionPointel(pointel(i));
        CHECK(ends == 2);  // the middle of the top and of the bottom: five junction linels each
    }

    TEST_CASE("interfaces: ranges hold their surfels in ascending order") {
        const auto surface = extractSurface(randomGrid(9, {9, 8, 7}, 4), {});
        REQUIRE(surface);
        std::size_t total = 0;
        for (std::size_t i = 0; i < surface->interfaces.size(); ++i) {
            const Interface& patch = surface->interfaces.raw()[i];
            CHECK(patch.end > patch.begin);
            for (std::uint32_t at = patch.begin; at < patch.end; ++at) {
                CHECK(index(surface->interfaceOf[surface->byInterface[at]]) == i);
                if (at > patch.begin)
                    CHECK(surface->byInterface[at - 1] < surface->byInterface[at]);
            }
            total += patch.end - patch.begin;
        }
        CHECK(total == surface->surfelCount());
    }

    // A closed surface encloses no net area: the oriented unit normals of a label cancel.
    TEST_CASE("property: the normals around each label sum to zero") {
        for (std::uint32_t seed = 100; seed < 130; ++seed) {
            CAPTURE(seed);
            const auto surface = extractSurface(randomGrid(seed, {6, 6, 6}, 3), {});
            REQUIRE(surface);
            std::map<Label, Vec3i> sums;
            for (std::size_t i = 0; i < surface->surfelCount(); ++i) {
                const LabelPair pair = surface->interfaces[surface->interfaceOf[surfel(i)]].labels;
                sums.try_emplace(pair.inner, Vec3i::Zero());
                sums.try_emplace(pair.outer, Vec3i::Zero());
                sums[pair.inner] += surface->trivialNormal(surfel(i));
                sums[pair.outer] -= surface->trivialNormal(surfel(i));
            }
            for (const auto& [label, sum] : sums) CHECK(sum == Vec3i(0, 0, 0));
        }
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same surface") {
        const VoxelGrid grid = sectorGrid(40, 17);
        const auto one = extractSurface(grid, {.threads = 1});
        REQUIRE(one);
        for (const int threads : {2, 7}) {
            const auto other = extractSurface(grid, {.threads = threads});
            REQUIRE(other);
            CHECK(other->pointels == one->pointels);
            CHECK(other->neighbours == one->neighbours);
            CHECK(other->corners == one->corners);
            CHECK(other->byInterface == one->byInterface);
            CHECK(other->junctionSlots == one->junctionSlots);
        }
    }

    TEST_CASE("scale: empty bricks of a 2000^3 grid cost next to nothing") {
        VoxelGrid grid = makeGrid({1, 1, 1}, 1, [](const Vec3i&) { return 0; });
        grid.voxels = BrickGrid(Vec3i::Constant(2000));
        const Vec3i corners[] = {{0, 0, 0}, {1999, 1999, 1999}, {1000, 17, 3}, {1000, 15, 3}};
        for (const Vec3i& voxel : corners) grid.voxels.set(voxel, MaterialId{1});
        const auto started = std::chrono::steady_clock::now();
        const auto surface = extractSurface(grid, {});
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - started;
        REQUIRE(surface);
        CHECK(surface->surfelCount() == 24);
        CHECK(grid.voxels.memoryBytes() < 10'000'000);
        CHECK(elapsed.count() < 10);  // every voxel would be 8e9 looks
    }

    TEST_CASE("count: agrees with the surface") {
        const VoxelGrid grid = sectorGrid(24, 10);
        const auto size = countSurface(grid, {});
        const auto surface = extractSurface(grid, {});
        REQUIRE(size);
        REQUIRE(surface);
        CHECK(size->surfels == surface->surfelCount());
        CHECK(size->pointels == surface->pointelCount());
    }

    TEST_CASE("reject: a cancelled run") {
        const auto surface =
            extractSurface(ballGrid(12, 4), {.stopRequested = [] { return true; }});
        REQUIRE_FALSE(surface);
        CHECK(surface.error().code == ErrorCode::cancelled);
    }

    TEST_CASE("links: symmetric, and complete away from junctions") {
        for (const VoxelGrid& grid :
             {ballGrid(16, 6), sectorGrid(16, 6), checkerboard(), randomGrid(3, {6, 6, 6}, 3)}) {
            const auto surface = extractSurface(grid, {});
            REQUIRE(surface);
            const auto links = linkSurfels(*surface, {});
            REQUIRE(links);
            for (std::size_t i = 0; i < surface->surfelCount(); ++i)
                for (const SurfelId g : (*links)[surfel(i)]) {
                    if (g == kNone<SurfelId>) continue;
                    const auto& back = (*links)[g];
                    CHECK(std::count(back.begin(), back.end(), surfel(i)) == 1);
                }
        }
    }

    TEST_CASE("links: on a checkerboard each background voxel is lined by its own surfels") {
        const VoxelGrid grid = checkerboard();
        const auto surface = extractSurface(grid, {});
        REQUIRE(surface);
        const auto links = linkSurfels(*surface, {});
        REQUIRE(links);
        for (std::size_t i = 0; i < surface->surfelCount(); ++i)
            for (int k = 0; k < 4; ++k) {
                const SurfelId g = (*links)[surfel(i)][k];
                REQUIRE(g != kNone<SurfelId>);
                // Next to the border of the grid the sheet goes on to the outside.
                const Vec3i voxel = surface->outerVoxel(surfel(i));
                const Vec3i other = surface->outerVoxel(g);
                const BrickGrid& box = grid.voxels;
                if (box.contains(voxel) && box.contains(other)) CHECK(voxel == other);
            }
    }
}
