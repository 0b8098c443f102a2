#include <doctest/doctest.h>

#include "core/grid/scene.h"
#include "core/samples/samples.h"
#include "tests/support/accuracy.h"
#include "tests/support/balls.h"
#include "tests/support/grids.h"
#include "tests/support/intersections.h"
#include "tests/support/landscape.h"
#include "tests/support/regularized.h"
#include "tests/support/voxel_centres.h"

using namespace rivage::core;
using namespace rivage::test;

TEST_SUITE("core/pipeline") {
    TEST_CASE("checker: unmoved surfaces have no wrong centre, a shifted one has many") {
        for (const VoxelGrid& grid :
             {ballGrid(14, 5.2), sectorGrid(16, 6.5), randomGrid(3, {6, 7, 5}, 3)}) {
            const DigitalSurface surface = *extractSurface(grid, {});
            PointelVectors positions(surface.pointelCount());
            for (std::size_t i = 0; i < positions.size(); ++i)
                positions.raw()[i] = surface.pointels.raw()[i].cast<double>();
            CHECK(countWrongCentres(grid, surface, positions) == 0);
            for (Vec3d& x : positions) x.z() += 1;
            CHECK(countWrongCentres(grid, surface, positions) > 10);
        }
    }

    TEST_CASE("separation: below half a voxel every voxel centre keeps its label") {
        std::vector<VoxelGrid> grids = {sectorGrid(20, 8.5), randomGrid(5, {9, 8, 7}, 4)};
        for (const SampleInfo& info : sampleInfos())
            grids.push_back(
                *mergeScene(*makeSample(std::string(info.name)), {.labels = info.labels}, {}));
        for (const VoxelGrid& grid : grids)
            for (const bool untangled : {true, false}) {
                MethodOptions options;
                options.solve.untangle = untangled;
                options.solve.tolerance = 1e-4;
                const Regularized result = regularize(grid, options);
                CHECK(countWrongCentres(grid, result.surface, result.positions) == 0);
                CHECK(countOpenEdges(result.surface) == 0);
                CHECK(countOrphans(result.surface) == 0);
                if (!untangled) continue;
                CHECK(invertedFaces(result.surface, result.positions).empty());
                CHECK(countIntersections(result.surface, result.positions) == 0);
            }
    }

    TEST_CASE("closed: every label, whatever touches whatever, split or not") {
        for (const VoxelGrid& grid : {landscapeGrid(), speckledGrid(ballsGrid(32), 3),
                                      randomGrid(3, Vec3i::Constant(16), 3)})
            for (const bool split : {true, false}) {
                const Regularized result = linkedSurface(grid, {.energy = {.split = split}});
                CHECK(countOpenEdges(result.surface) == 0);
                CHECK(countOrphans(result.surface) == 0);
            }
    }

    TEST_CASE("separation: without a limit it does not hold, so the check can fail") {
        MethodOptions options = presetOptions(Preset::paper);
        options.normals = {.method = NormalMethod::trivial};
        options.energy.gamma = 5;
        const VoxelGrid grid = randomGrid(5, {9, 8, 7}, 4);
        const Regularized result = regularize(grid, options);
        CHECK(countWrongCentres(grid, result.surface, result.positions) > 0);
    }
}
