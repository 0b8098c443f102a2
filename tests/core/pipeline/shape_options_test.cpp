#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <random>

#include "core/mesh/inverted.h"
#include "core/pipeline.h"
#include "tests/support/grids.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

using Bytes = std::vector<std::byte>;

/// A ball that leaves a raw grid of 12 x 10 x 8 through its low sides.
constexpr int kNx = 12;
constexpr int kNy = 10;
constexpr int kNz = 8;
Bytes cutBall() {
    Bytes bytes;
    for (int z = 0; z < kNz; ++z)
        for (int y = 0; y < kNy; ++y)
            for (int x = 0; x < kNx; ++x)
                bytes.push_back(static_cast<std::byte>(x * x + y * y + z * z < 36 ? 7 : 0));
    return bytes;
}

ConversionOptions rawOptions() {
    ConversionOptions options;
    options.input.format = GridFormat::raw;
    options.input.dims = Vec3i(kNx, kNy, kNz);
    options.method.solve.tolerance = 1e-3;
    return options;
}

ConversionReport reportOf(const ConversionOptions& options, const Bytes& bytes = cutBall()) {
    const auto artifact = convert(bytes, options, {}, {});
    REQUIRE(artifact);
    return artifact->report;
}

/// The positions of a plain OBJ, in its own units.
std::vector<Vec3d> objPositions(const ConversionOptions& options) {
    const auto artifact = convert(cutBall(), options, {}, {});
    REQUIRE(artifact);
    std::vector<Vec3d> positions;
    const std::string text(reinterpret_cast<const char*>(artifact->bytes.data()),
                           artifact->bytes.size());
    for (std::size_t at = text.find("\nv "); at != std::string::npos;
         at = text.find("\nv ", at + 1)) {
        double x = 0;
        double y = 0;
        double z = 0;
        REQUIRE(std::sscanf(text.c_str() + at, "\nv %lf %lf %lf", &x, &y, &z) == 3);
        positions.emplace_back(x, y, z);
    }
    return positions;
}

Vec3d extent(const std::vector<Vec3d>& positions) {
    Vec3d low = positions.at(0);
    Vec3d high = low;
    for (const Vec3d& at : positions) {
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
    }
    return high - low;
}

std::array<Vec3d, 4> movedSquare(std::mt19937& random, double reach) {
    std::array<Vec3d, 4> at = {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(1, 1, 0), Vec3d(0, 1, 0)};
    std::uniform_real_distribution<double> unit(-reach, reach);
    const bool extreme = random() % 2 == 0;
    for (Vec3d& corner : at)
        for (int axis = 0; axis < 3; ++axis) {
            const double d = unit(random);
            corner[axis] += extreme ? std::copysign(reach, d) : d;
        }
    return at;
}

Vec3d cornerNormal(const std::array<Vec3d, 4>& at, std::size_t k) {
    return (at[(k + 1) % 4] - at[k]).cross(at[(k + 3) % 4] - at[k]);
}

}  // namespace

TEST_SUITE("core/pipeline") {
    TEST_CASE("border: an open one leaves the region open there and nowhere else") {
        ConversionOptions options = rawOptions();
        const ConversionReport closed = reportOf(options);
        CHECK(closed.output.closed == std::vector<bool>{true});
        CHECK(closed.output.openAtBorder == std::vector<bool>{false});
        CHECK(closed.input.dims == std::array<int, 3>{6, 6, 6});
        options.input.border = Border::open;
        const ConversionReport open = reportOf(options);
        CHECK(open.output.closed == std::vector<bool>{false});
        CHECK(open.output.openAtBorder == std::vector<bool>{true});
        CHECK(open.surface.surfels == closed.surface.surfels / 2);
        // A volume is the whole of what was scanned, empty or not.
        CHECK(open.input.dims == std::array<int, 3>{kNx, kNy, kNz});
        CHECK(guaranteesOf(open).closed == Evidence::none);
        CHECK(toJson(open)["open_at_border"]["7"] == true);
        const auto inspection = inspect(cutBall(), options.input, {});
        REQUIRE(inspection);
        CHECK(inspection->surfels == open.surface.surfels);
        CHECK(inspection->pointels == open.surface.pointels);
    }

    TEST_CASE("reject: an open border around a grid of one region") {
        ConversionOptions options = rawOptions();
        options.input.border = Border::open;
        const auto artifact = convert(Bytes(kNx * kNy * kNz, std::byte{1}), options, {}, {});
        REQUIRE_FALSE(artifact);
        CHECK(artifact.error().code == ErrorCode::emptyGrid);
        CHECK(artifact.error().field == "/options/border");
    }

    TEST_CASE("spacing: the result is as long as the voxels are, in shortest sides") {
        ConversionOptions options = rawOptions();
        options.output.format = OutputFormat::obj;
        options.output.up = UpAxis::z;
        options.output.voxelSize = 0.5;
        options.method.solve.displacementLimit = 0.01;
        options.input.spacing = Vec3d(0.2, 0.2, 0.5);  // 1 x 1 x 2.5
        const Vec3d size = extent(objPositions(options));
        const Vec3d expected = 0.5 * Vec3d(6, 6, 15);
        for (int axis = 0; axis < 3; ++axis)
            CHECK(std::abs(size[axis] - expected[axis]) <= 0.5 * 2 * 0.01 * 2.5 + 1e-6);
    }

    TEST_CASE("spacing: scaling all sides changes nothing") {
        ConversionOptions options = rawOptions();
        const auto plain = convert(cutBall(), options, {}, {});
        options.input.spacing = Vec3d::Constant(4);
        const auto scaled = convert(cutBall(), options, {}, {});
        REQUIRE(plain);
        REQUIRE(scaled);
        CHECK(plain->bytes == scaled->bytes);
    }

    TEST_CASE("spacing: untangle measures areas and angles in it") {
        VoxelGrid grid = randomGrid(3, {6, 6, 6}, 2);
        grid.spacing = Vec3d(1, 3, 20);
        const DigitalSurface surface = *extractSurface(grid, {});
        IdVector<PointelId, Vec3d> rest(surface.pointelCount());
        for (std::uint32_t i = 0; i < rest.size(); ++i)
            rest[PointelId{i}] = surface.position(PointelId{i});
        CHECK(invertedFaces(surface, rest).empty());
        std::mt19937 random(1);
        std::uniform_real_distribution<double> unit(-0.49, 0.49);
        IdVector<PointelId, Vec3d> moved = rest;
        for (Vec3d& at : moved)
            at += Vec3d(unit(random), unit(random), unit(random)).cwiseProduct(grid.spacing);
        CHECK(untangle(surface, moved, {}).inverted > 0);
        CHECK(invertedFaces(surface, moved).empty());
    }

    TEST_CASE("weights: a region is held, an unknown one is refused") {
        ConversionOptions options = rawOptions();
        const ConversionReport plain = reportOf(options);
        options.method.energy.regions = {{.region = "7", .alpha = 1000}};
        CHECK(reportOf(options).solve.displacementRms < 0.5 * plain.solve.displacementRms);
        options.method.energy.regions = {{.region = "8", .alpha = 1000}};
        const auto artifact = convert(cutBall(), options, {}, {});
        REQUIRE_FALSE(artifact);
        CHECK(artifact.error().code == ErrorCode::invalidOption);
        CHECK(artifact.error().field == "/options/weights/8");
    }

    TEST_CASE("guarantees: follow the largest displacement and the split pointels") {
        ConversionOptions options = rawOptions();
        const Guarantees studio = guaranteesOf(reportOf(options));
        CHECK(studio.separation == Evidence::proved);
        CHECK(studio.noIntersection == Evidence::proved);
        CHECK(studio.noInversion == Evidence::checked);
        CHECK(studio.closed == Evidence::checked);
        options.method.solve.displacementLimit = 0.24;
        CHECK(guaranteesOf(reportOf(options)).noInversion == Evidence::proved);

        const auto board = sampleScene("checkerboard");
        REQUIRE(board);
        ConversionOptions defaults;
        defaults.method.solve.tolerance = 1e-3;
        const ConversionReport split = reportOf(defaults, *board);
        CHECK(split.surface.splitPointels == 343);
        CHECK(guaranteesOf(split).noIntersection == Evidence::checked);

        ConversionReport far = split;
        far.solve.displacementMax = 0.5;
        far.solve.invertedAfter = 1;
        CHECK(guaranteesOf(far).separation == Evidence::none);
        CHECK(guaranteesOf(far).noIntersection == Evidence::none);
        CHECK(guaranteesOf(far).noInversion == Evidence::none);
        CHECK(toJson(split)["guarantees"]["separation"] == "proved");
    }

    // Below a quarter of a voxel every corner normal keeps a positive part along the axis of the
    // face, so both triangles of either cut do. The corner normals may still be more than a right
    // angle apart, but only from (sqrt(3) - 1) / 4 = 0.183 voxels on.
    TEST_CASE("property: below 1/4 voxel no face folds over, below 0.183 none counts as inverted") {
        std::mt19937 random(7);
        const double strict = (std::sqrt(3.0) - 1) / 4;
        int apart = 0;
        for (int i = 0; i < 200000; ++i) {
            const auto face = movedSquare(random, 0.2499);
            const auto tame = movedSquare(random, strict - 1e-6);
            for (std::size_t k = 0; k < 4; ++k) {
                REQUIRE(cornerNormal(face, k).z() > 0);
                for (std::size_t l = 0; l < k; ++l) {
                    REQUIRE(cornerNormal(tame, k).dot(cornerNormal(tame, l)) > 0);
                    apart += cornerNormal(face, k).dot(cornerNormal(face, l)) < 0 ? 1 : 0;
                }
            }
        }
        CHECK(apart > 0);
        // The worst face: its opposite corners reach a right angle at that limit.
        for (const double reach : {strict - 1e-3, strict + 1e-3}) {
            const std::array<Vec3d, 4> face = {
                Vec3d(reach, reach, -reach), Vec3d(1 - reach, -reach, reach),
                Vec3d(1 - reach, 1 - reach, -reach), Vec3d(-reach, 1 - reach, reach)};
            CHECK((cornerNormal(face, 0).dot(cornerNormal(face, 2)) > 0) == (reach < strict));
        }
    }
}
