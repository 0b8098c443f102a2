#include "tests/study/peers.h"

#include <doctest/doctest.h>

#include <array>
#include <map>
#include <set>

#include "tests/study/methods.h"
#include "tests/support/grids.h"

using namespace rivage::study;
using namespace rivage::test;

TEST_SUITE_BEGIN("study");

namespace {

NormalField constantNormals(const DigitalSurface& surface, const Vec3d& normal) {
    return {surface.surfelCount(), normal};
}

/// How often each directed edge of the faces of a label occurs, against the reverse one.
std::size_t openEdges(const StudyMesh& mesh, Label label) {
    std::map<std::array<std::uint32_t, 2>, int> balance;
    for (const Face& face : mesh.faces) {
        if (face.labels.inner != label && face.labels.outer != label) continue;
        const bool flip = face.labels.outer == label;
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = face.corners[k];
            const std::uint32_t b = face.corners[(k + 1) % 3];
            balance[{std::min(a, b), std::max(a, b)}] += (a < b) != flip ? 1 : -1;
        }
    }
    std::size_t open = 0;
    for (const auto& [edge, sum] : balance) open += sum != 0;
    return open;
}

double volumeOf(const StudyMesh& mesh) {
    double volume = 0;
    for (const Face& face : mesh.faces)
        for (const auto& t : trianglesOf(mesh, face)) volume += t[0].dot(t[1].cross(t[2])) / 6;
    return volume;
}

StudyMesh marchingCubesOf(const VoxelGrid& grid) {
    const DigitalSurface surface = *extractSurface(grid, {});
    return marchingCubes(grid, surface, crossings(surface, 0, 1));
}

}  // namespace

// Every cell of a random grid is another of the 256 cases.
TEST_CASE("property: marching cubes closes the surface on any grid") {
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(seed);
        const StudyMesh mesh = marchingCubesOf(randomGrid(seed, Vec3i(7, 6, 5), 1));
        CHECK(openEdges(mesh, Label{1}) == 0);
    }
}

TEST_CASE("marching cubes: an octahedron of volume 1/6 around a lone voxel, facing outwards") {
    const StudyMesh mesh = marchingCubesOf(
        makeGrid(Vec3i::Constant(3), 1, [](const Vec3i& v) { return v == Vec3i::Ones() ? 1 : 0; }));
    CHECK(mesh.faces.size() == 8);
    CHECK(volumeOf(mesh) == doctest::Approx(1.0 / 6));
}

// Two triangles to each label, one on either side of the interface.
TEST_CASE("marching cubes: interfaces between two labels come once for each label") {
    const VoxelGrid grid =
        makeGrid(Vec3i(8, 8, 8), 2, [](const Vec3i& v) { return v.x() < 4 ? 1 : 2; });
    std::map<LabelPair, std::size_t> faces;
    for (const Face& face : marchingCubesOf(grid).faces) ++faces[face.labels];
    CHECK(faces.size() == 3);
    CHECK(faces[LabelPair{Label{1}, Label{2}}] >= 2 * 2 * 6 * 6);
}

TEST_CASE("dual contouring: exact on a plane whose crossings and normals are known") {
    const Vec3d normal = Vec3d(0.3, -0.5, 0.8).normalized();
    const Vec3d through(6.2, 5.9, 6.1);
    const VoxelGrid grid = makeGrid(Vec3i::Constant(12), 1, [&](const Vec3i& v) {
        return normal.dot(v.cast<double>() + Vec3d::Constant(0.5) - through) <= 0 ? 1 : 0;
    });
    const DigitalSurface surface = *extractSurface(grid, {});
    Crossings points = crossings(surface, 0, 1);
    std::set<std::uint32_t> atBorder;
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
        const SurfelId s{i};
        const Vec3d along = surface.trivialNormal(s).cast<double>();
        const double t = normal.dot(through - points[s]) / normal.dot(along);
        points[s] += t * along;
        const Vec3d centre = surface.centre(s);
        if (centre.minCoeff() > 0.6 && centre.maxCoeff() < 11.4) continue;
        for (const PointelId p : surface.corners[s]) atBorder.insert(index(p));
    }
    const PointelVectors x =
        dualContouring(surface, points, constantNormals(surface, normal), false);
    std::size_t checked = 0;
    for (std::uint32_t i = 0; i < x.size(); ++i) {
        if (atBorder.count(i) != 0) continue;
        CHECK(std::abs(normal.dot(x[PointelId{i}] - through)) < 1e-9);
        ++checked;
    }
    CHECK(checked > 50);
}

TEST_CASE("dual contouring: finds the corner of three planes, and the cell keeps it") {
    const VoxelGrid grid =
        makeGrid(Vec3i::Constant(4), 1, [](const Vec3i& v) { return v.minCoeff() >= 2 ? 1 : 0; });
    const DigitalSurface surface = *extractSurface(grid, {});
    NormalField normals(surface.surfelCount(), Vec3d::Zero());
    for (std::uint32_t i = 0; i < normals.size(); ++i)
        normals[SurfelId{i}] = surface.trivialNormal(SurfelId{i}).cast<double>();
    const Crossings points = crossings(surface, 0, 1);
    const PointelVectors free = dualContouring(surface, points, normals, false);
    for (std::uint32_t i = 0; i < free.size(); ++i) {
        // Voxels cut along their own sides: every vertex is where it rests.
        CHECK((free[PointelId{i}] - surface.position(PointelId{i})).norm() < 1e-9);
    }
    NormalField skew = normals;
    for (Vec3d& normal : skew) normal = (normal + Vec3d(0.9, 0.9, 0.8)).normalized();
    const PointelVectors kept = dualContouring(surface, points, skew, true);
    for (std::uint32_t i = 0; i < kept.size(); ++i)
        CHECK((kept[PointelId{i}] - surface.position(PointelId{i})).cwiseAbs().maxCoeff() <= 0.5);
}

// Three planes through the crossings of a corner, each tilted a little against the first.
TEST_CASE("dual contouring: planes are told apart down to a tenth, no further") {
    const VoxelGrid grid = makeGrid(Vec3i::Ones(), 1, [](const Vec3i&) { return 1; });
    const DigitalSurface surface = *extractSurface(grid, {});
    const Crossings points = crossings(surface, 0, 1);
    for (const double tilt : {0.35, 0.05}) {
        CAPTURE(tilt);
        NormalField normals(surface.surfelCount(), Vec3d::UnitZ());
        for (std::uint32_t i = 0; i < normals.size(); ++i)
            if (surface.axis[SurfelId{i}] != 2)
                normals[SurfelId{i}][surface.axis[SurfelId{i}]] = tilt;
        for (Vec3d& normal : normals) normal.normalize();
        const PointelVectors x = dualContouring(surface, points, normals, false);
        double most = 0;
        for (std::uint32_t i = 0; i < surface.surfelCount(); ++i)
            for (const PointelId p : surface.corners[SurfelId{i}])
                most =
                    std::max(most, std::abs(normals[SurfelId{i}].dot(x[p] - points[SurfelId{i}])));
        CHECK((most < 1e-9) == (tilt > 0.1));
    }
}

TEST_CASE("surface nets: the vertices of a lone voxel lie two thirds out") {
    const VoxelGrid grid = makeGrid(Vec3i::Ones(), 1, [](const Vec3i&) { return 1; });
    const DigitalSurface surface = *extractSurface(grid, {});
    const Crossings points = crossings(surface, 0, 1);
    const Vec3d middle = Vec3d::Constant(0.5);
    const PointelVectors x = surfaceNets(surface, points, 0);
    // Half a step towards the mean of three neighbours takes 1/3 to (1/3 + 1/9) / 2 = 2/9 of the
    // way from the middle to the corner: 1/6 to 1/9.
    const PointelVectors moved = surfaceNets(surface, points, 1);
    for (std::uint32_t i = 0; i < x.size(); ++i) {
        const PointelId p{i};
        const Vec3d out = surface.position(p) - middle;
        CHECK((x[p] - middle - out / 3).norm() < 1e-12);
        CHECK((moved[p] - middle - out * 2 / 9).norm() < 1e-12);
    }
}

TEST_CASE("surface nets: a plane along the grid stays, and junctions move along themselves") {
    const VoxelGrid grid =
        makeGrid(Vec3i(12, 12, 12), 2, [](const Vec3i& v) { return v.x() < 6 ? 1 : 2; });
    const DigitalSurface surface = *extractSurface(grid, {});
    const PointelVectors x = surfaceNets(surface, crossings(surface, 0, 1), 16);
    for (std::uint32_t i = 0; i < x.size(); ++i) {
        const Vec3i& at = surface.pointels[PointelId{i}];
        if (at.x() == 6) CHECK(x[PointelId{i}].x() == doctest::Approx(6));
    }
}

TEST_CASE("crossings: noise moves them along their edges only, at most so far") {
    const DigitalSurface surface = *extractSurface(ballGrid(12, 4.3), {});
    const Crossings still = crossings(surface, 0, 7);
    const Crossings moved = crossings(surface, 0.25, 7);
    double most = 0;
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
        const SurfelId s{i};
        const Vec3d step = moved[s] - still[s];
        most = std::max(most, step.norm());
        CHECK(step.cross(surface.trivialNormal(s).cast<double>()).norm() < 1e-12);
    }
    CHECK(most <= 0.25);
    CHECK(most > 0.2);
}

TEST_SUITE_END();
