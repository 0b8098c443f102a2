#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <tuple>

#include "core/mesh/diagonal.h"
#include "core/voxelize/windings.h"
#include "tests/core/voxelize/voxelize_fixtures.h"

using namespace rivage::test;

namespace {

Label labelAt(const LabelColumns& columns, const Vec3i& sample) {
    Label label{0};
    for (const LabelRun& run : columns.column(sample.x(), sample.y()))
        if (run.begin <= sample.z()) label = run.label;
    return label;
}

template <typename Visit>
void forEachSample(const Vec3i& size, Visit&& visit) {
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x) visit(Vec3i(x, y, z));
}

/// All crossings of the columns of one lattice, by column and sample.
std::vector<Crossing> allCrossings(const Sampled& model, const SampleLattice& lattice) {
    std::vector<Crossing> crossings;
    for (std::uint32_t i = 0; i < model.surface->surfelCount(); ++i)
        appendCrossings(*model.moved, SurfelId{i}, lattice, {}, crossings);
    std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
        return std::tie(a.column, a.sample) < std::tie(b.column, b.sample);
    });
    return crossings;
}

/// The windings at a point by looking at each triangle below it, in floating point.
Windings slowWindings(const Sampled& model, const Vec3d& at) {
    Windings windings(Label{0});
    for (std::uint32_t i = 0; i < model.surface->surfelCount(); ++i) {
        const SurfelId s{i};
        const auto& pointels = model.surface->corners[s];
        const std::uint32_t k = firstCorner(pointels, *model.positions);
        const auto corner = [&](std::uint32_t c) -> Vec3d {
            return model.moved->snapped[pointels[(k + c) % 4]].cast<double>() / kUnitsPerVoxel;
        };
        for (const std::uint32_t second : {1U, 2U}) {
            const Vec3d a = corner(0);
            const Vec3d b = corner(second);
            const Vec3d c = corner(second + 1);
            const Vec3d normal = (b - a).cross(c - a);
            const auto side = [&](const Vec3d& p, const Vec3d& q) {
                return (q - p).cross(at - p).z() * (normal.z() > 0 ? 1 : -1);
            };
            if (side(a, b) <= 0 || side(b, c) <= 0 || side(c, a) <= 0) continue;
            const Vec3d ahead = at - a;
            if (normal.dot(ahead) * normal.z() <= 0) continue;  // the point is below
            const LabelPair labels = model.moved->labels(s);
            if (normal.z() > 0)
                windings.pass(labels.inner, labels.outer);
            else
                windings.pass(labels.outer, labels.inner);
        }
    }
    return windings;
}

/// The squared distance to the nearest middle of a face of a label, by looking at each.
double nearestFace(const Sampled& model, const Vec3d& at, Label label) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < model.surface->surfelCount(); ++i) {
        const LabelPair labels = model.moved->labels(SurfelId{i});
        if (labels.inner != label && labels.outer != label) continue;
        nearest = std::min(nearest, (model.moved->centre(SurfelId{i}) - at).squaredNorm());
    }
    return nearest;
}

}  // namespace

TEST_SUITE("core/voxelize") {
    TEST_CASE("windings: the sum is 1, whatever is passed") {
        Windings windings(Label{0});
        CHECK(windings.only() == Label{0});
        windings.pass(Label{1}, Label{2});
        CHECK(windings.sum() == 1);
        CHECK(windings.of(Label{1}) == -1);
        CHECK_FALSE(windings.only());
        CHECK(windings.most() == std::vector<Label>{Label{0}, Label{2}});
        windings.pass(Label{0}, Label{1});
        CHECK(windings.only() == Label{2});
    }

    TEST_CASE("property: labels are closed: above all faces only the background is left") {
        for (const double amplitude : {0.0, 0.25, 0.49, 3.0})
            for (std::uint32_t seed = 1; seed <= 8; ++seed) {
                CAPTURE(amplitude);
                CAPTURE(seed);
                const Sampled model = moved(randomGrid(seed, {5, 6, 4}, 3), amplitude, seed);
                // One block of columns, and as much room above as any vertex can move.
                const SampleLattice lattice{2, 1, {10, 12, 20}};
                const std::vector<Crossing> crossings = allCrossings(model, lattice);
                REQUIRE_FALSE(crossings.empty());
                Windings windings(Label{0});
                for (std::size_t i = 0; i < crossings.size(); ++i) {
                    if (i > 0 && crossings[i].column != crossings[i - 1].column) {
                        REQUIRE(windings.only() == Label{0});
                        windings = Windings(Label{0});
                    }
                    windings.pass(crossings[i].from, crossings[i].to);
                    REQUIRE(windings.sum() == 1);
                }
                CHECK(windings.only() == Label{0});
            }
    }

    TEST_CASE("differential: every sample as by looking at each triangle") {
        for (const double amplitude : {0.3, 0.49, 1.5}) {
            CAPTURE(amplitude);
            const Sampled model = moved(randomGrid(3, {4, 4, 3}, 3), amplitude, 5);
            const LabelColumns columns = model.scan(3, 1);
            std::size_t ties = 0;
            forEachSample(columns.lattice().size, [&](const Vec3i& sample) {
                // Off every edge by a step that is smaller than any distance between samples and
                // edges but where they touch.
                const Vec3d at = columns.lattice().position(sample) + Vec3d(2e-9, 1e-9, 1e-9);
                const std::vector<Label> most = slowWindings(model, at).most();
                const Label label = labelAt(columns, sample);
                ties += most.size() > 1;
                REQUIRE(std::find(most.begin(), most.end(), label) != most.end());
                // On a tie the label whose nearest face is nearest.
                const Vec3d exact = columns.lattice().position(sample);
                const double distance = nearestFace(model, exact, label);
                for (const Label other : most)
                    REQUIRE(distance <= nearestFace(model, exact, other));
            });
            CHECK(columns.folded() >= ties);
            CHECK((amplitude < 1 || ties > 0));
        }
    }

    TEST_CASE("lattice: where nothing moved each sample has the label of its voxel") {
        // Samples between two voxels belong to the higher one.
        for (const Scale scale :
             {Scale{1, 1}, Scale{2, 1}, Scale{3, 1}, Scale{4, 1}, Scale{3, 2}, Scale{5, 3}}) {
            CAPTURE(scale.up);
            CAPTURE(scale.down);
            const Sampled model = moved(randomGrid(7, {18, 7, 6}, 4), 0);
            const LabelColumns columns = model.scan(scale.up, scale.down);
            CHECK(columns.folded() == 0);
            forEachSample(columns.lattice().size, [&](const Vec3i& sample) {
                REQUIRE(labelAt(columns, sample) ==
                        model.grid.labelAt(columns.lattice().voxelOf(sample)));
            });
        }
    }

    TEST_CASE("property: an open border has the labels of its voxels at their centres") {
        for (std::uint32_t seed = 1; seed <= 10; ++seed) {
            CAPTURE(seed);
            VoxelGrid grid = randomGrid(seed, {5, 4, 6}, 2);
            grid.openBorder = true;
            const Sampled model = moved(std::move(grid), 0.45, seed);
            const LabelColumns columns = model.scan(5);
            forEachSample(model.grid.voxels.size(), [&](const Vec3i& voxel) {
                REQUIRE(labelAt(columns, 5 * voxel + Vec3i(2, 2, 2)) == model.grid.labelAt(voxel));
            });
        }
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same runs") {
        const Sampled model = moved(sectorGrid(24, 10), 0.49);
        const LabelColumns one = model.scan(3, 2, 1);
        for (const int threads : {2, 7}) {
            const LabelColumns other = model.scan(3, 2, threads);
            forEachSample(one.lattice().size,
                          [&](const Vec3i& s) { REQUIRE(labelAt(one, s) == labelAt(other, s)); });
        }
    }

    TEST_CASE("reject: a stop at any poll") {
        const Sampled model = moved(ballGrid(20, 8), 0.3);
        const SampleLattice lattice = SampleLattice::over(model.grid.voxels.size(), 2, 1);
        std::size_t total = 0;
        REQUIRE(scanLabels(model.grid, *model.moved, *model.nearest, lattice,
                           {.stopRequested = [&] { return ++total, false; }}));
        for (std::size_t at = 1; at < total; at += 1 + total / 20) {
            std::size_t polls = 0;
            const auto columns = scanLabels(model.grid, *model.moved, *model.nearest, lattice,
                                            {.stopRequested = [&] { return ++polls >= at; }});
            REQUIRE_FALSE(columns);
            CHECK(columns.error().code == ErrorCode::cancelled);
        }
    }
}
