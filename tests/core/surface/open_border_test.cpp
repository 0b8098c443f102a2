#include <doctest/doctest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "core/surface/split_umbrellas.h"
#include "tests/support/grids.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

using Face = std::tuple<int, int, int, int>;  // z, y, x of the high voxel, axis

VoxelGrid opened(VoxelGrid grid) {
    grid.openBorder = true;
    return grid;
}

/// Pairs of voxels of the grid that differ, the obvious way.
std::set<Face> slowFaces(const VoxelGrid& grid) {
    std::set<Face> faces;
    const Vec3i size = grid.voxels.size();
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x)
                for (int axis = 0; axis < 3; ++axis) {
                    const Vec3i high(x, y, z);
                    if (high[axis] == 0) continue;
                    if (grid.labelAt(high) != grid.labelAt(high - Vec3i::Unit(axis)))
                        faces.insert({z, y, x, axis});
                }
    return faces;
}

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }
PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }

}  // namespace

TEST_SUITE_BEGIN("core/surface");

TEST_CASE("open border: exactly the faces between two voxels of the grid") {
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        CAPTURE(seed);
        const VoxelGrid grid = opened(randomGrid(seed, {18, 4, 5}, 1 + static_cast<int>(seed % 3)));
        const DigitalSurface surface = *extractSurface(grid, {});
        std::set<Face> found;
        std::set<PointelId> used;
        for (std::size_t i = 0; i < surface.surfelCount(); ++i) {
            const auto& corners = surface.corners[surfel(i)];
            const Vec3i& at = surface.pointels[corners[0]];
            found.insert({at.z(), at.y(), at.x(), surface.axis[surfel(i)]});
            used.insert(corners.begin(), corners.end());
        }
        CHECK(found.size() == surface.surfelCount());
        CHECK(found == slowFaces(grid));
        CHECK(used.size() == surface.pointelCount());
        CHECK(countSurface(grid, {})->surfels == surface.surfelCount());
        CHECK(countSurface(grid, {})->pointels == surface.pointelCount());
    }
}

TEST_CASE("open border: neighbours are the ends of edges of faces") {
    const DigitalSurface surface = *extractSurface(opened(randomGrid(4, {5, 6, 4}, 2)), {});
    std::set<std::pair<PointelId, PointelId>> edges;
    for (const auto& corners : surface.corners)
        for (int k = 0; k < 4; ++k) edges.insert(std::minmax(corners[k], corners[(k + 1) % 4]));
    std::size_t ends = 0;
    for (std::size_t i = 0; i < surface.pointelCount(); ++i)
        for (const PointelId q : surface.neighbours[pointel(i)]) {
            if (q == kNone<PointelId>) continue;
            ++ends;
            CHECK(edges.count(std::minmax(pointel(i), q)) == 1);
        }
    CHECK(ends == 2 * edges.size());
}

TEST_CASE("open border: pointels on the border may not leave it, copies neither") {
    const VoxelGrid grid = opened(randomGrid(6, {6, 5, 7}, 1));
    DigitalSurface surface = *extractSurface(grid, {});
    const SurfelLinks links = *linkSurfels(surface, {});
    CHECK(*splitUmbrellas(surface, links, {}) > 10);
    REQUIRE(surface.fixedAxes.size() == surface.pointelCount());
    std::set<int> seen;
    for (std::size_t i = 0; i < surface.pointelCount(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const int at = surface.pointels[pointel(i)][axis];
            const bool border = at == 0 || at == grid.voxels.size()[axis];
            CHECK((surface.fixedAxes[pointel(i)] >> axis & 1) == (border ? 1 : 0));
            seen.insert(surface.fixedAxes[pointel(i)]);
        }
    CHECK(seen.size() == 7);  // none, one axis, two axes; never a corner of the grid
    CHECK(extractSurface(randomGrid(6, {6, 5, 7}, 1), {})->fixedAxes.empty());
}

TEST_CASE("open border: one region that fills the grid has no surface") {
    const auto surface =
        extractSurface(opened(makeGrid({3, 4, 5}, 1, [](const Vec3i&) { return 1; })), {});
    REQUIRE(surface);
    CHECK(surface->surfelCount() == 0);
    CHECK(surface->pointelCount() == 0);
}

TEST_CASE("determinism: an open border with threads 1, 2, 7") {
    const VoxelGrid grid = opened(randomGrid(2, {30, 20, 25}, 3));
    const DigitalSurface one = *extractSurface(grid, {.threads = 1});
    for (const int threads : {2, 7}) {
        const DigitalSurface other = *extractSurface(grid, {.threads = threads});
        CHECK(other.corners == one.corners);
        CHECK(other.fixedAxes == one.fixedAxes);
        CHECK(other.neighbours == one.neighbours);
    }
}

TEST_CASE("spacing: places, centres and areas are in units of the shortest side") {
    VoxelGrid grid = makeGrid({2, 3, 1}, 1, [](const Vec3i&) { return 1; });
    grid.spacing = Vec3d(1, 2.5, 4);
    const DigitalSurface surface = *extractSurface(grid, {});
    CHECK(surface.faceArea(0) == 10);
    CHECK(surface.faceArea(1) == 4);
    CHECK(surface.faceArea(2) == 2.5);
    double area = 0;
    Vec3d high = Vec3d::Zero();
    for (std::size_t i = 0; i < surface.surfelCount(); ++i) {
        const auto& c = surface.corners[surfel(i)];
        const Vec3d middle = 0.25 * (surface.position(c[0]) + surface.position(c[1]) +
                                     surface.position(c[2]) + surface.position(c[3]));
        CHECK((surface.centre(surfel(i)) - middle).norm() < 1e-12);
        area += surface.faceArea(surface.axis[surfel(i)]);
        high = high.cwiseMax(surface.position(c[2]));
    }
    CHECK(high == Vec3d(2, 7.5, 4));
    CHECK(area == 2 * (2 * 7.5 + 7.5 * 4 + 4 * 2));
}

TEST_SUITE_END();
