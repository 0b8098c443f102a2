#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/accuracy.h"
#include "tests/support/shapes.h"
#include "tests/support/walls.h"

// The limits that `./dev bench accuracy` keeps, on what takes seconds. Voxels and degrees.

using namespace rivage::core;
using namespace rivage::test;

namespace {

constexpr std::uint32_t kNoiseSeed = 7;

PositionErrors defaultErrors(const Shape& shape) {
    return positionErrors(shape, regularize(shape.grid, {}));
}

/// A surface that nothing has moved.
Regularized unmoved(const Shape& shape) {
    Regularized result = linkedSurface(shape.grid, {});
    result.positions.resize(result.surface.pointelCount());
    for (std::uint32_t i = 0; i < result.positions.size(); ++i)
        result.positions[PointelId{i}] = result.surface.position(PointelId{i});
    return result;
}

/// Whether the distance of a shape grows along its normal, by as much as one goes, and both voxels
/// of a surfel are on the side of their label.
void checkSurfel(const Shape& shape, const DigitalSurface& surface, SurfelId s) {
    const LabelPair& labels = surface.interfaces[surface.interfaceOf[s]].labels;
    const Vec3d centre = surface.centre(s);
    if (!shape.measured(labels, centre)) return;
    const Vec3d half = 0.5 * surface.trivialNormal(s).cast<double>();
    REQUIRE(shape.distance(labels, centre - half) <= 1e-9);
    REQUIRE(shape.distance(labels, centre + half) >= -1e-9);
    if (shape.edge(labels, centre) < 1) return;
    const Vec3d step = 1e-4 * shape.normal(labels, centre);
    const double growth =
        shape.distance(labels, centre + step) - shape.distance(labels, centre - step);
    REQUIRE(growth == doctest::Approx(2e-4).epsilon(1e-6));
}

double meanNormalError(const Shape& shape, Regularized& result, const NormalOptions& options) {
    constexpr std::size_t kLeastPart = 40;  // surfels; smaller parts are specks of noise
    result.normals = *estimateNormals(shape.grid, result.surface, result.links, options, {});
    return normalErrors(shape, result, kLeastPart).mean;
}

}  // namespace

TEST_SUITE("core/pipeline") {
    // What is measured is only worth something if the shapes are what their grids show.
    TEST_CASE("shapes: the distance is that of the grid, the normal is its slope") {
        for (const Shape& shape :
             {sphereShape(), sectorsShape(), sampleBoxShape(), randomBoxShape(1), cappedBallShape(),
              torusShape(), cubeShape(10), cubeShape(1), ballsShape(64)}) {
            CAPTURE(shape.name);
            const Regularized result = unmoved(shape);
            const PositionErrors errors = positionErrors(shape, result);
            CHECK(errors.max <= std::sqrt(3) / 2 + 1e-9);
            CHECK(std::abs(errors.bias) < 0.1);
            for (std::uint32_t i = 0; i < result.surface.surfelCount(); ++i)
                checkSurfel(shape, result.surface, SurfelId{i});
        }
    }

    TEST_CASE("measures: volumes of the lattice are exact, a shifted face is seen") {
        for (const Shape& shape : {sectorsShape(), ballsShape(32)}) {
            Regularized result = unmoved(shape);
            CHECK(volumeErrorPercent(shape.grid, result) < 1e-9);
            CHECK(countOpenEdges(result.surface) == 0);
            CHECK(countOrphans(result.surface) == 0);
            for (Vec3d& x : result.positions) x *= 1.01;
            CHECK(volumeErrorPercent(shape.grid, result) == doctest::Approx(3.0301));
            result.surface.corners.raw().pop_back();
            CHECK(countOpenEdges(result.surface) >= 4);
        }
        CHECK(countOpenEdges(linkedSurface(wallGrid({0, 0, 1}), {}).surface) > 0);
    }

    TEST_CASE("accuracy: sphere") {
        const PositionErrors errors = defaultErrors(sphereShape());
        CHECK(errors.rms < 0.05);
        CHECK(errors.normalMean < 1.2);
    }

    TEST_CASE("accuracy: a ball in three sectors") {
        const PositionErrors errors = defaultErrors(sectorsShape());
        CHECK(errors.rms < 0.06);
        CHECK(errors.normalMean < 1.6);
    }

    TEST_CASE("accuracy: rotated boxes, their normals up to 1 voxel from the edges") {
        for (const Shape& shape :
             {sampleBoxShape(), randomBoxShape(1), randomBoxShape(2), randomBoxShape(3)}) {
            CAPTURE(shape.name);
            const Regularized result = regularize(shape.grid, {});
            const PositionErrors errors = positionErrors(shape, result);
            CHECK(errors.rms < 0.07);
            CHECK(errors.normalMean < 2.2);
            const NormalErrors normals = normalErrors(shape, result);
            CHECK(normals.nearEdges > 0);
            CHECK(normals.nearEdges < 2);
        }
    }

    TEST_CASE("accuracy: a cube along the grid keeps its corners, a lone voxel too") {
        const Vec3i size = Vec3i::Constant(10);
        const Regularized cube = regularize(cubeShape(10).grid, {});
        CHECK(largestDisplacement(cube, size, 3) < 0.05);
        CHECK(largestDisplacement(cube, size, 2) < 0.05);
        const Regularized voxel = regularize(cubeShape(1).grid, {});
        CHECK(largestDisplacement(voxel, Vec3i::Ones(), 3) < 0.02);
    }

    TEST_CASE("accuracy: walls one voxel thick do not collapse, whatever their direction") {
        for (const Vec3i& normal : wallNormals()) {
            const std::string name = std::to_string(normal.x()) + " " + std::to_string(normal.y()) +
                                     " " + std::to_string(normal.z());
            CAPTURE(name);
            const Sides sides = measureSides(regularize(wallGrid(normal), {}), normal);
            CHECK(sides.thickness >= 0.8 * idealThickness(normal));
        }
    }

    TEST_CASE("accuracy: normals off by 10 degrees move a sphere by less than 0.08") {
        const Shape shape = sphereShape();
        Regularized result = regularize(shape.grid, {});
        result.normals = tilted(result.normals, 10, kNoiseSeed);
        alignToNormals(result, {});
        CHECK(positionErrors(shape, result).rms < 0.08);
    }

    TEST_CASE("accuracy: large balls are no worse than small ones") {
        struct Row {
            int side;
            double rms;
        };
        for (const Row& row : {Row{64, 0.05}, Row{128, 0.04}}) {
            CAPTURE(row.side);
            const Shape shape = ballsShape(row.side);
            const Regularized result = regularize(shape.grid, {});
            const PositionErrors errors = positionErrors(shape, result);
            CHECK(errors.rms <= row.rms);
            CHECK(errors.normalMean <= 1.2);
            CHECK(volumeErrorPercent(shape.grid, result) < 0.3);
            CHECK(countOpenEdges(result.surface) == 0);
        }
    }

    TEST_CASE("accuracy: flipped labels, automatic normals are no worse than the better of two") {
        for (const Shape& clean : {sphereShape(), sectorsShape(), randomBoxShape(1)}) {
            CAPTURE(clean.name);
            const Shape shape = withLabelNoise(clean, 0.2, kNoiseSeed);
            Regularized result = linkedSurface(shape.grid, {});
            const double convolved =
                meanNormalError(shape, result, {.method = NormalMethod::convolved, .radius = 5});
            const double smooth =
                meanNormalError(shape, result, {.method = NormalMethod::piecewiseSmooth});
            CHECK(meanNormalError(shape, result, {}) <= std::min(convolved, smooth));
        }
    }
}
