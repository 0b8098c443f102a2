#include "core/emboss/charts.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/grids.h"
#include "tests/support/regularized.h"

using namespace rivage::test;

namespace {

IdVector<SurfelId, SurfelTile> placed(const VoxelGrid& grid, const Regularized& made,
                                      const TileChoice& choice) {
    return placeTiles({made.surface, made.links, made.normals, made.positions, sceneOrigin(grid)},
                      choice, {});
}

TileChoice bricks(const VoxelGrid& grid) {
    return *TileChoice::make(grid, {.rules = {{"*", {.kind = TileKind::brick}}}}, 0.25);
}

/// Half a cylinder along x.
VoxelGrid barrel() {
    return makeGrid({24, 40, 22}, 1, [](const Vec3i& v) {
        return std::hypot(v.y() + 0.5 - 20, v.z() + 0.5) < 19 ? 1 : 0;
    });
}

}  // namespace

TEST_SUITE_BEGIN("core/emboss");

TEST_CASE("placeTiles: on a barrel roof courses go on from the eaves nearly to the ridge") {
    const VoxelGrid grid = barrel();
    const Regularized made = regularize(grid, {});
    const TileChoice choice = bricks(grid);
    const auto tiles = placed(grid, made, choice);
    double worst = 0;
    double unshifted = 0;
    std::size_t borders = 0;
    for (std::uint32_t i = 0; i < made.surface.surfelCount(); ++i)
        for (std::size_t k = 0; k < 4; ++k) {
            const SurfelId s{i};
            const SurfelId g = made.links[s][k];
            if (g == kNone<SurfelId> || tiles[s].frame == tiles[g].frame) continue;
            const Vec3d at = made.positions[made.surface.corners[s][k]];
            const bool roof = made.normals[s].x() * made.normals[s].x() < 0.01 &&
                              made.normals[g].x() * made.normals[g].x() < 0.01;
            // Level ground at the ridge and below keeps the world's alignment.
            const bool sloped = tiles[s].frame.slope || tiles[g].frame.slope;
            const bool level =
                std::abs(made.normals[s].z()) > 0.97 || std::abs(made.normals[g].z()) > 0.97;
            if (!roof || !sloped || level || at.z() < 1) continue;
            ++borders;
            const double apart = (tiles[s].frame.v - tiles[g].frame.v).dot(at);
            unshifted = std::max(unshifted, std::abs(apart));
            worst = std::max(worst, std::abs(apart + tiles[s].shiftV - tiles[g].shiftV));
        }
    CHECK(borders > 80);
    CHECK(unshifted > 2);
    CHECK(worst < 0.5);
}

TEST_CASE("placeTiles: walls and level ground keep the world's alignment") {
    const VoxelGrid grid = makeGrid({8, 8, 8}, 1, [](const Vec3i&) { return 1; });
    const Regularized made = regularize(grid, {});
    const TileChoice choice = bricks(grid);
    for (const SurfelTile& tile : placed(grid, made, choice)) CHECK(tile.shiftV == 0);
}

TEST_SUITE_END();
