#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "core/normals/convolved.h"
#include "core/normals/normal_field.h"
#include "core/samples/samples.h"
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

/// The normal of the face of the box nearest to a point, 0 outside the given distances from the
/// edges.
Vec3d boxNormal(const SampleBox& box, const Vec3d& point, double nearest, double farthest) {
    const Mat3d axes = box.axes();
    const Vec3d local = axes.transpose() * (point - box.center);
    const Vec3d beyond = local.cwiseAbs() - box.halfSides;
    if (beyond.maxCoeff() < -2 || beyond.maxCoeff() > 2) return Vec3d::Zero();  // of a loose voxel
    std::array<double, 3> distances{std::abs(beyond[0]), std::abs(beyond[1]), std::abs(beyond[2])};
    std::sort(distances.begin(), distances.end());
    const double edge = std::hypot(distances[0], distances[1]);
    if (edge < nearest || edge > farthest) return Vec3d::Zero();
    int axis = 0;
    beyond.maxCoeff(&axis);
    return axes.col(axis) * (local[axis] > 0 ? 1 : -1);
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

    TEST_CASE("accuracy: automatic normals of balls from small to large, mean angle in degrees") {
        for (const double radius : {3.5, 4.7, 6.2, 8.3, 12.3, 31.0}) {
            CAPTURE(radius);
            const int side = 2 * static_cast<int>(radius) + 6;
            const Vec3d shift(0.13, 0.31, -0.22);
            const double error = meanError(ballGrid(side, radius, shift), {}, [&](const Vec3d& p) {
                return (p - Vec3d::Constant(side / 2.0) - shift).normalized();
            });
            CHECK(error < (radius > 20 ? 0.7 : 1.5));
        }
    }

    TEST_CASE("accuracy: the normals of a cube are exact up to its edges") {
        const VoxelGrid grid = makeGrid({10, 10, 10}, 1, [](const Vec3i&) { return 1; });
        const auto face = [](const Vec3d& p) {
            const Vec3d q = p - Vec3d::Constant(5);
            int axis = 0;
            q.cwiseAbs().maxCoeff(&axis);
            return Vec3d(Vec3d::Unit(axis) * (q[axis] > 0 ? 1 : -1));
        };
        CHECK(meanError(grid, {}, face) < 1e-6);
        CHECK(meanError(grid, {.method = NormalMethod::discVote}, face) < 1e-6);
        CHECK(meanError(grid, {.method = NormalMethod::convolved}, face) > 5);
    }

    TEST_CASE("accuracy: piecewise smooth normals find the edges of a rotated box") {
        const SampleBox box;
        const VoxelGrid grid = makeGrid(box.size, 1, [&](const Vec3i& v) {
            return signedDistance(box, v.cast<double>() + Vec3d::Constant(0.5)) <= 0;
        });
        const auto oneToThreeFromAnEdge = [&](const Vec3d& p) { return boxNormal(box, p, 1, 3); };
        const auto error = [&](NormalMethod method) {
            return meanError(grid, {.method = method}, oneToThreeFromAnEdge);
        };
        const double convolved = error(NormalMethod::convolved);
        CHECK(error(NormalMethod::piecewiseSmooth) < 0.75 * convolved);
        CHECK(error(NormalMethod::guided) < 0.75 * convolved);
        CHECK(error(NormalMethod::discVote) < 1);
        CHECK(error(NormalMethod::automatic) < 1);
    }

    TEST_CASE("piecewise smooth: the features of a cube are its edges, a ball has none") {
        const auto features = [](const VoxelGrid& grid) {
            const DigitalSurface surface = *extractSurface(grid, {});
            const auto estimate =
                estimateNormalsAndChoices(grid, surface, *linkSurfels(surface, {}),
                                          {.method = NormalMethod::piecewiseSmooth}, {});
            return *estimate->featureLinels;
        };
        const auto cube = features(makeGrid({16, 16, 16}, 1, [](const Vec3i&) { return 1; }));
        CHECK(cube >= 12 * 12);
        CHECK(cube <= 12 * 16 * 2);
        CHECK(features(ballGrid(40, 16.3)) == 0);
    }

    TEST_CASE("noise: clean shapes are clean, flipped boundary voxels are not") {
        const auto levels = [](const VoxelGrid& grid) {
            const DigitalSurface surface = *extractSurface(grid, {});
            std::vector<double> noise;
            const auto estimate =
                estimateNormalsAndChoices(grid, surface, *linkSurfels(surface, {}), {}, {});
            for (const InterfaceNormals& choice : estimate->interfaces)
                noise.push_back(choice.noise);
            return noise;
        };
        for (const SampleInfo& info : sampleInfos()) {
            // Thin everywhere, as noise is.
            if (info.name == "checkerboard") continue;
            CAPTURE(info.name);
            const VoxelGrid grid =
                *mergeScene(*makeSample(std::string(info.name)), {.labels = info.labels}, {});
            for (const double level : levels(grid)) CHECK(level == 0);
        }
        const VoxelGrid ball = ballGrid(32, 13.1);
        for (const double level : levels(ball)) CHECK(level == 0);
        for (const double level : levels(withLabelNoise(ball, 0.1, 5))) CHECK(level == 1);
        for (const double level : levels(withLabelNoise(sectorGrid(40, 16), 0.2, 6)))
            CHECK(level == 1);
    }

    TEST_CASE("noise: automatic normals are no worse than the better of two that know of it") {
        const SampleBox box;
        const VoxelGrid boxGrid = makeGrid(box.size, 1, [&](const Vec3i& v) {
            return signedDistance(box, v.cast<double>() + Vec3d::Constant(0.5)) <= 0;
        });
        const Vec3d centre = Vec3d::Constant(16);
        const auto ballNormal = [&](const Vec3d& p) {
            const double distance = (p - centre).norm();
            return std::abs(distance - 12.7) < 2 ? Vec3d((p - centre) / distance)
                                                 : Vec3d(Vec3d::Zero());
        };
        const auto boxFaceNormal = [&](const Vec3d& p) { return boxNormal(box, p, 1, 100); };
        for (const double flips : {0.1, 0.2, 0.3}) {
            CAPTURE(flips);
            const auto check = [&](const VoxelGrid& grid, const auto& truth) {
                const VoxelGrid noisy = withLabelNoise(grid, flips, 9);
                const double convolved =
                    meanError(noisy, {.method = NormalMethod::convolved, .radius = 5}, truth);
                const double smooth =
                    meanError(noisy, {.method = NormalMethod::piecewiseSmooth}, truth);
                CHECK(meanError(noisy, {}, truth) <= std::min(convolved, smooth));
            };
            check(ballGrid(32, 12.7), ballNormal);
            check(boxGrid, boxFaceNormal);
        }
    }

    TEST_CASE("spacing: a ball squeezed along z has the normals of a ball") {
        const Vec3d spacing(1, 1, 2.5);
        const double radius = 14;
        const Vec3d centre = Vec3d(16.2, 15.9, 16.1);
        VoxelGrid grid = makeGrid({32, 32, 13}, 1, [&](const Vec3i& v) {
            const Vec3d p = (v.cast<double>() + Vec3d::Constant(0.5)).cwiseProduct(spacing);
            return (p - centre).norm() <= radius;
        });
        DigitalSurface surface = *extractSurface(grid, {});
        surface.spacing = spacing;
        const SurfelLinks links = *linkSurfels(surface, {});
        for (const NormalMethod method :
             {NormalMethod::automatic, NormalMethod::guided, NormalMethod::convolved,
              NormalMethod::integralInvariant}) {
            const NormalField normals =
                *estimateNormals(grid, surface, links, {.method = method, .radius = 5}, {});
            double sum = 0;
            for (std::size_t i = 0; i < normals.size(); ++i)
                sum += degrees(normals.raw()[i], (surface.centre(surfel(i)) - centre).normalized());
            CHECK(sum / static_cast<double>(normals.size()) < 3.5);
        }
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
             {NormalMethod::automatic, NormalMethod::guided, NormalMethod::discVote,
              NormalMethod::convolved, NormalMethod::integralInvariant,
              NormalMethod::piecewiseSmooth, NormalMethod::robust}) {
            const NormalOptions options{.method = method};
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
        for (const NormalMethod method :
             {NormalMethod::automatic, NormalMethod::guided, NormalMethod::discVote,
              NormalMethod::convolved, NormalMethod::integralInvariant,
              NormalMethod::piecewiseSmooth, NormalMethod::robust}) {
            const auto normals =
                estimateNormals(grid, *surface, *linkSurfels(*surface, {}), {.method = method},
                                {.stopRequested = [] { return true; }});
            REQUIRE_FALSE(normals);
            CHECK(normals.error().code == ErrorCode::cancelled);
        }
    }
}
