#include "core/emboss/emboss.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/emboss/tile.h"
#include "core/mesh/closed.h"
#include "tests/support/grids.h"
#include "tests/support/regularized.h"
#include "tests/support/voxel_centres.h"

using namespace rivage::test;

namespace {

constexpr EmbossMethod kMethods[] = {EmbossMethod::normals, EmbossMethod::displace};

ConversionOptions withTile(const TileOptions& tile, EmbossMethod method, int detail = 4) {
    ConversionOptions options;
    options.emboss = {.rules = {{"*", tile}}, .detail = detail, .method = method};
    return options;
}

Embossed embossed(const VoxelGrid& grid, const Regularized& made, const ConversionOptions& options,
                  int threads = 1) {
    return *emboss({grid, made.surface, made.links, made.normals, made.positions}, options,
                   {.threads = threads});
}

/// Heights that rise and fall smoothly along both axes, three waves on 12 columns.
TileOptions waves(double depth) {
    TileOptions tile{.size = 6, .depth = depth};
    for (int y = 0; y < 24; ++y) {
        tile.heights.emplace_back();
        for (int x = 0; x < 24; ++x)
            tile.heights.back().push_back(0.5 + 0.25 * std::sin(2 * M_PI * (x + 0.5) / 24) +
                                          0.25 * std::cos(2 * M_PI * (y + 0.5) / 24));
    }
    return tile;
}

/// The largest way along an axis from the own place on the voxel face, in sides of a voxel.
double largestDisplacement(const Embossed& result) {
    double largest = 0;
    const DigitalSurface& surface = result.refined.surface;
    for (std::uint32_t i = 0; i < surface.pointelCount(); ++i) {
        const Vec3d d = result.positions[PointelId{i}] - surface.position(PointelId{i});
        largest = std::max(largest, d.cwiseQuotient(surface.spacing).cwiseAbs().maxCoeff() /
                                        result.refined.detail);
    }
    return largest;
}

/// The largest error of the relief against the tile, less its mean, on the top of a slab, away
/// from its border; voxels.
double errorOnSlab(const Embossed& result, const HeightTile& tile, const Vec3i& size, int rim) {
    double error = 0;
    double offset = 0;
    int count = 0;
    const DigitalSurface& surface = result.refined.surface;
    for (const bool measure : {false, true})
        for (std::uint32_t i = 0; i < surface.pointelCount(); ++i) {
            const Vec3d at = surface.position(PointelId{i});
            const bool inside = at.x() >= rim && at.y() >= rim && at.x() <= size.x() - rim &&
                                at.y() <= size.y() - rim;
            if (!inside || at.z() != size.z()) continue;
            const Vec3d& rest = result.refined.rest[PointelId{i}];
            const double off =
                result.positions[PointelId{i}].z() - rest.z() - tile.at(rest.x(), rest.y());
            if (measure)
                error = std::max(error, std::abs(off - offset / count));
            else
                offset += off, ++count;
        }
    return error;
}

VoxelGrid slab(const Vec3i& size) {
    return makeGrid(size, 1, [](const Vec3i&) { return 1; });
}

}  // namespace

TEST_SUITE_BEGIN("core/emboss");

TEST_CASE("emboss: a flat tile changes nothing beyond the pieces, bit by bit") {
    const VoxelGrid grid = sectorGrid(14, 5.5);
    const Regularized made = regularize(grid, {});
    for (const EmbossMethod method : kMethods) {
        const TileOptions flat{.heights = {{0.3, 0.3}, {0.3, 0.3}}};
        const Embossed result = embossed(grid, made, withTile(flat, method));
        CHECK(result.positions == result.refined.rest);
        const TileOptions shallow{.kind = TileKind::brick, .depth = 0};
        CHECK(embossed(grid, made, withTile(shallow, method)).positions == result.refined.rest);
    }
}

// What is left is the mean slope of a piece in place of those of its edges.
TEST_CASE("emboss: on a flat face normals give the heights back, up to their mean") {
    const Vec3i size(30, 30, 4);
    const VoxelGrid grid = slab(size);
    const Regularized made = regularize(grid, {});
    const TileOptions tile = waves(0.2);
    const Embossed result = embossed(grid, made, withTile(tile, EmbossMethod::normals));
    CHECK(errorOnSlab(result, HeightTile(tile, 0.25), size, 6) < 0.001);
    CHECK(result.report.reliefMax == 0);  // the caller measures
    CHECK(result.report.iterations > 0);
}

TEST_CASE("emboss: on a flat face displace gives the heights exactly") {
    const Vec3i size(16, 16, 4);
    const VoxelGrid grid = slab(size);
    const Regularized made = regularize(grid, {});
    for (const TileOptions& tile : {waves(0.2), TileOptions{.kind = TileKind::cobble}}) {
        const Embossed result = embossed(grid, made, withTile(tile, EmbossMethod::displace));
        CHECK(errorOnSlab(result, HeightTile(tile, 0.25), size, 3) < 1e-7);
    }
}

TEST_CASE("emboss: the box holds on the pieces, so every voxel centre keeps its label") {
    // Far deeper than the box allows.
    const TileOptions deep{.kind = TileKind::cobble, .size = 3, .depth = 1};
    std::size_t labels = 1;
    for (const VoxelGrid& grid :
         {sectorGrid(16, 6.5), ballGrid(12, 5), randomGrid(3, {6, 6, 6}, 3)})
        for (const EmbossMethod method : kMethods) {
            CAPTURE(labels++);
            const Regularized made = regularize(grid, {});
            const Embossed result = embossed(grid, made, withTile(deep, method, 3));
            CHECK(largestDisplacement(result) <= 0.49 + 1e-12);
            CHECK(largestDisplacement(result) > 0.48);
            CHECK(countWrongCentres(grid, result.refined.surface, result.positions) == 0);
            const std::vector<Closure> all(grid.labels.size() - 1, Closure::closed);
            CHECK(labelClosures(grid, result.refined.surface) == all);
        }
}

TEST_CASE("emboss: no pointel moves further than the depth, none without a tile moves") {
    VoxelGrid grid = makeGrid({12, 12, 6}, 2, [](const Vec3i& v) { return v.x() < 6 ? 1 : 2; });
    const Regularized made = regularize(grid, {});
    for (const EmbossMethod method : kMethods) {
        ConversionOptions options = withTile({.kind = TileKind::brick, .depth = 0.1}, method);
        options.emboss.rules[0].material = "label 1";
        const Embossed result = embossed(grid, made, options);
        std::size_t moved = 0;
        double largest = 0;
        for (std::uint32_t i = 0; i < result.positions.size(); ++i) {
            const Vec3d relief = result.positions[PointelId{i}] - result.refined.rest[PointelId{i}];
            largest = std::max(largest, relief.cwiseAbs().maxCoeff());
            if (result.refined.surface.position(PointelId{i}).x() > 6)
                CHECK(relief == Vec3d(0, 0, 0));
            else
                moved += relief.isZero(1e-4) ? 0 : 1;
        }
        CHECK(moved > 1000);
        CHECK(largest <= 0.1 + 1e-6);
    }
}

TEST_CASE("emboss: an entry is stronger than a region, a region than the rest") {
    VoxelGrid grid = makeGrid({9, 4, 4}, 3, [](const Vec3i& v) { return v.x() / 3 + 1; });
    grid.materials.raw()[2].name = "plaster";
    const Regularized made = regularize(grid, {});
    ConversionOptions options = withTile({.kind = TileKind::brick}, EmbossMethod::displace, 2);
    options.emboss.rules = {{"*", {.kind = TileKind::brick}},
                            {"plaster", {.kind = TileKind::planks}},
                            {"label 3", {.kind = TileKind::cobble}},
                            {"label 2", {.kind = TileKind::cobble}},
                            {"3", {.kind = TileKind::panels}}};
    const auto& tiles = embossed(grid, made, options).report.tiles;
    // Faces between two regions are those of the inner one: the smaller label.
    const std::uint64_t ends = 16 + 16 + 4 * 12;
    CHECK(tiles[0].surfels == ends);
    CHECK(tiles[1].surfels == 16 + 4 * 12);
    CHECK(tiles[2].surfels == 0);
    CHECK(tiles[3].surfels == 0);
    CHECK(tiles[4].surfels == 16 + 4 * 12);
    CHECK(tiles[4].tile == "panels");
}

TEST_CASE("reject: a material that the grid does not have") {
    const VoxelGrid grid = ballGrid(5, 2);
    const Regularized made = regularize(grid, {});
    ConversionOptions options = withTile({.kind = TileKind::brick}, EmbossMethod::normals);
    options.emboss.rules.push_back({"roof", {.kind = TileKind::planks}});
    const auto result =
        emboss({grid, made.surface, made.links, made.normals, made.positions}, options, {});
    REQUIRE_FALSE(result);
    CHECK(result.error().code == ErrorCode::invalidOption);
    CHECK(result.error().field == "/options/emboss/roof");
    CHECK(result.error().message.find("label 1") != std::string::npos);
}

TEST_CASE("determinism: the same bits for 1, 2 and 7 threads") {
    const VoxelGrid grid = sectorGrid(16, 6.5);
    const Regularized made = regularize(grid, {});
    for (const EmbossMethod method : kMethods) {
        const ConversionOptions options = withTile({.kind = TileKind::brick}, method);
        const Embossed one = embossed(grid, made, options);
        for (const int threads : {2, 7})
            CHECK(embossed(grid, made, options, threads).positions == one.positions);
    }
}

TEST_CASE("emboss: stops when it is asked to") {
    const VoxelGrid grid = sectorGrid(14, 5.5);
    const Regularized made = regularize(grid, {});
    const RunContext run{.stopRequested = [] { return true; }};
    const auto result = emboss({grid, made.surface, made.links, made.normals, made.positions},
                               withTile({.kind = TileKind::brick}, EmbossMethod::normals), run);
    REQUIRE_FALSE(result);
    CHECK(result.error().code == ErrorCode::cancelled);
}

TEST_CASE("emboss: sides of a voxel that differ, and an open border") {
    VoxelGrid grid = sectorGrid(12, 9);
    grid.spacing = Vec3d(1, 1, 2);
    grid.openBorder = true;
    const Regularized made = regularize(grid, {});
    const Embossed result = embossed(
        grid, made, withTile({.kind = TileKind::brick, .depth = 0.3}, EmbossMethod::normals, 3));
    const DigitalSurface& surface = result.refined.surface;
    CHECK(largestDisplacement(result) <= 0.49 + 1e-12);
    std::size_t fixed = 0;
    for (std::uint32_t i = 0; i < surface.pointelCount(); ++i)
        for (int k = 0; k < 3; ++k) {
            if ((surface.fixedAxes[PointelId{i}] >> k & 1) == 0) continue;
            ++fixed;
            CHECK(result.positions[PointelId{i}][k] ==
                  doctest::Approx(surface.position(PointelId{i})[k]).epsilon(1e-12));
        }
    CHECK(fixed > 100);
}

TEST_SUITE_END();
