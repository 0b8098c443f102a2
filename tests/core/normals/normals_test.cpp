#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "core/normals/convolved.h"
#include "core/normals/normal_field.h"
#include "tests/support/grids.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }

double degrees(const Vec3d& a, const Vec3d& b) {
    return std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * 180 / M_PI;
}

/// Mean angle between estimated and true normals, over the surfels where `truth` knows one.
template <typename Truth>
double meanError(const VoxelGrid& grid, const NormalOptions& options, Truth&& truth) {
    const auto surface = extractSurface(grid, {});
    REQUIRE(surface);
    const auto normals = estimateNormals(grid, *surface, *linkSurfels(*surface, {}), options, {});
    REQUIRE(normals);
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < surface->surfelCount(); ++i) {
        const Vec3d centre = surface->doubleCentre(surfel(i)).cast<double>() / 2;
        const Vec3d expected = truth(centre);
        if (expected.isZero()) continue;
        CHECK((*normals)[surfel(i)].norm() == doctest::Approx(1));
        sum += degrees((*normals)[surfel(i)], expected);
        ++count;
    }
    REQUIRE(count > 0);
    return sum / count;
}

double sphereError(NormalMethod method, double radius) {
    constexpr int kSide = 30;
    const Vec3d shift(0.13, 0.31, -0.22);
    return meanError(
        ballGrid(kSide, 12.3, shift), {.method = method, .radius = radius},
        [&](const Vec3d& p) { return (p - Vec3d::Constant(kSide / 2.0) - shift).normalized(); });
}

}  // namespace

TEST_SUITE("core/normals") {
    TEST_CASE("trivial: lattice vectors from inner to outer") {
        const VoxelGrid grid = sectorGrid(12, 5);
        const auto surface = extractSurface(grid, {});
        REQUIRE(surface);
        const auto normals = estimateNormals(grid, *surface, *linkSurfels(*surface, {}),
                                             {.method = NormalMethod::trivial}, {});
        REQUIRE(normals);
        for (std::size_t i = 0; i < surface->surfelCount(); ++i)
            CHECK((*normals)[surfel(i)] ==
                  (surface->outerVoxel(surfel(i)) - surface->innerVoxel(surfel(i))).cast<double>());
    }

    TEST_CASE("accuracy: sphere of radius 12.3, mean angle in degrees") {
        CHECK(sphereError(NormalMethod::convolved, 3) < 2.8);
        CHECK(sphereError(NormalMethod::convolved, 5) < 1.2);
        CHECK(sphereError(NormalMethod::integralInvariant, 3) < 4.0);
        CHECK(sphereError(NormalMethod::integralInvariant, 5) < 1.8);
        CHECK(sphereError(NormalMethod::trivial, 3) > 30);  // what the others start from
    }

    TEST_CASE("accuracy: convolved normals of a digital plane average to the plane's") {
        const Vec3d plane = Vec3d(0.4, -0.3, 1).normalized();
        const Vec3d centre = Vec3d::Constant(20);
        const VoxelGrid grid = makeGrid(Vec3i::Constant(40), 1, [&](const Vec3i& v) {
            return (v.cast<double>() + Vec3d::Constant(0.5) - centre).dot(plane) <= 0.1;
        });
        const auto inside = [&](const Vec3d& p) {
            const bool far = (p - centre).cwiseAbs().maxCoeff() < 12;
            return far && std::abs((p - centre).dot(plane)) < 2 ? plane : Vec3d(Vec3d::Zero());
        };
        CHECK(meanError(grid, {.method = NormalMethod::convolved, .radius = 5}, inside) < 1);
    }

    TEST_CASE("convolved: the two sides of a diagonal one-voxel wall do not mix") {
        // A staircase wall: touching voxels share linels only, where four surfels meet.
        const VoxelGrid grid =
            makeGrid({20, 20, 12}, 1, [](const Vec3i& v) { return v.x() == v.y(); });
        const Vec3d side = Vec3d(1, -1, 0).normalized();
        const auto truth = [&](const Vec3d& p) {
            const bool inner = p.x() > 5 && p.x() < 15 && p.z() > 4 && p.z() < 8;
            if (!inner) return Vec3d(Vec3d::Zero());
            return p.x() > p.y() ? side : Vec3d(-side);
        };
        CHECK(meanError(grid, {.method = NormalMethod::convolved, .radius = 3}, truth) < 2);
    }

    TEST_CASE("convolved: one-sided at a junction of two labels on a wall") {
        // Two labels fill a box; their outer walls stay flat up to the line where they meet.
        const VoxelGrid grid =
            makeGrid({20, 10, 10}, 2, [](const Vec3i& v) { return v.x() < 10 ? 1 : 2; });
        const auto top = [](const Vec3d& p) {
            const bool middle = p.x() > 6 && p.x() < 14 && std::abs(p.y() - 5) < 1;
            return middle && p.z() == 10 ? Vec3d(0, 0, 1) : Vec3d(Vec3d::Zero());
        };
        CHECK(meanError(grid, {.method = NormalMethod::convolved, .radius = 4}, top) < 1e-9);
    }

    TEST_CASE("integral invariants: next to a junction the convolved normal stands in") {
        const VoxelGrid grid = sectorGrid(24, 10);
        const auto surface = extractSurface(grid, {});
        REQUIRE(surface);
        const NormalOptions options{.method = NormalMethod::integralInvariant, .radius = 3};
        const auto normals =
            estimateNormals(grid, *surface, *linkSurfels(*surface, {}), options, {});
        const auto links = linkSurfels(*surface, {});
        REQUIRE(normals);
        REQUIRE(links);
        PatchWalker walker(*surface, *links);
        for (std::size_t i = 0; i < surface->surfelCount(); ++i) {
            const auto& corners = surface->corners[surfel(i)];
            const bool junction = std::any_of(corners.begin(), corners.end(), [&](PointelId p) {
                return surface->junctionSlots[p] != 0;
            });
            if (junction)
                CHECK((*normals)[surfel(i)] == convolvedNormal(*surface, walker, surfel(i), 3));
        }
    }

    TEST_CASE("thin: a lone voxel and a one-voxel sheet keep their trivial normals") {
        for (const Vec3i& size : {Vec3i(1, 1, 1), Vec3i(13, 13, 1)}) {
            const VoxelGrid grid = makeGrid(size, 1, [](const Vec3i&) { return 1; });
            const auto surface = extractSurface(grid, {});
            REQUIRE(surface);
            const auto normals =
                estimateNormals(grid, *surface, *linkSurfels(*surface, {}),
                                {.method = NormalMethod::convolved, .radius = 3}, {});
            REQUIRE(normals);
            for (std::size_t i = 0; i < surface->surfelCount(); ++i) {
                const Vec3d centre = surface->doubleCentre(surfel(i)).cast<double>() / 2;
                const bool rim =
                    (centre.head<2>() - size.head<2>().cast<double>() / 2).cwiseAbs().maxCoeff() >
                    3;
                if (rim && size.x() > 1) continue;
                CHECK((*normals)[surfel(i)].dot(surface->trivialNormal(surfel(i)).cast<double>()) >
                      0.999);
            }
        }
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same bits") {
        const VoxelGrid grid = sectorGrid(40, 17);
        const auto surface = extractSurface(grid, {});
        REQUIRE(surface);
        for (const NormalMethod method :
             {NormalMethod::convolved, NormalMethod::integralInvariant}) {
            const NormalOptions options{.method = method, .radius = 3};
            const auto one = estimateNormals(grid, *surface, *linkSurfels(*surface, {}), options,
                                             {.threads = 1});
            REQUIRE(one);
            for (const int threads : {2, 7})
                CHECK(*estimateNormals(grid, *surface, *linkSurfels(*surface, {}), options,
                                       {.threads = threads}) == *one);
        }
    }

    TEST_CASE("reject: a cancelled run") {
        const VoxelGrid grid = ballGrid(12, 4);
        const auto surface = extractSurface(grid, {});
        REQUIRE(surface);
        const auto normals = estimateNormals(grid, *surface, *linkSurfels(*surface, {}), {},
                                             {.stopRequested = [] { return true; }});
        REQUIRE_FALSE(normals);
        CHECK(normals.error().code == ErrorCode::cancelled);
    }
}
