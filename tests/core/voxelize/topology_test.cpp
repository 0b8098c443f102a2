#include <doctest/doctest.h>

#include "core/voxelize/topology.h"
#include "tests/support/grids.h"

using namespace rivage::test;

namespace {

void checkTopology(const VoxelGrid& grid, std::size_t label, std::uint64_t components,
                   std::uint64_t tunnels, std::uint64_t cavities) {
    const auto topologies = labelTopology(grid, {});
    REQUIRE(topologies);
    const auto& topology = topologies->at(label - 1);
    CHECK(topology.components == components);
    CHECK(topology.tunnels == tunnels);
    CHECK(topology.cavities == cavities);
}

}  // namespace

TEST_SUITE("core/voxelize") {
    TEST_CASE("topology: a ball, a hollow ball, a ring, a cup, two balls") {
        checkTopology(ballGrid(12, 5), 1, 1, 0, 0);
        checkTopology(makeGrid({12, 12, 12}, 1,
                               [](const Vec3i& v) {
                                   const double r =
                                       (v.cast<double>() - Vec3d::Constant(5.5)).norm();
                                   return r < 5.5 && r > 3;
                               }),
                      1, 1, 0, 1);
        const auto ring = [](const Vec3i& v) {
            return (v - Vec3i(3, 3, 0)).cwiseAbs().maxCoeff() <= 3 && !(v.x() == 3 && v.y() == 3);
        };
        checkTopology(makeGrid({7, 7, 2}, 1, ring), 1, 1, 1, 0);
        checkTopology(makeGrid({7, 7, 4}, 1, [&](const Vec3i& v) { return v.z() == 0 || ring(v); }),
                      1, 1, 0, 0);
        checkTopology(makeGrid({9, 3, 3}, 1, [](const Vec3i& v) { return v.x() % 4 == 0; }), 1, 3,
                      0, 0);
    }

    TEST_CASE("topology: voxels that meet in an edge or a corner hang together") {
        const auto meeting = [](const Vec3i& at) {
            return makeGrid({2, 2, 2}, 1,
                            [&](const Vec3i& v) { return v == Vec3i::Zero() || v == at; });
        };
        checkTopology(meeting({1, 1, 0}), 1, 1, 0, 0);
        checkTopology(meeting({1, 1, 1}), 1, 1, 0, 0);
        // Six voxels around one that is empty: closed by edges and corners, not by faces.
        checkTopology(
            makeGrid({3, 3, 3}, 1,
                     [](const Vec3i& v) { return (v - Vec3i::Ones()).cwiseAbs().sum() == 1; }),
            1, 1, 0, 1);
    }

    TEST_CASE("topology: each label for itself; one without voxels has nothing") {
        // A core of label 2 fills the cavity of label 1.
        const VoxelGrid grid =
            makeGrid({5, 5, 5}, 3, [](const Vec3i& v) { return v == Vec3i(2, 2, 2) ? 2 : 1; });
        checkTopology(grid, 1, 1, 0, 1);
        checkTopology(grid, 2, 1, 0, 0);
        checkTopology(grid, 3, 0, 0, 0);
    }

    TEST_CASE("reject: a stop") {
        CHECK_FALSE(labelTopology(ballGrid(20, 8), {.stopRequested = [] { return true; }}));
    }
}
