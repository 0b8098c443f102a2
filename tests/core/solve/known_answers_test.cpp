#include <doctest/doctest.h>

#include "core/normals/normal_field.h"
#include "core/normals/patch_walker.h"
#include "core/solve/minimize.h"
#include "tests/support/goursat.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

const EnergyOptions kPaper = presetOptions(Preset::paper).energy;

/// The convolved normals of the reference implementation: its hat is upside down, so that the
/// weights 1 - 1/t + d/t^2 grow with the distance.
NormalField invertedHatNormals(const DigitalSurface& surface, double t) {
    const auto links = linkSurfels(surface, {});
    REQUIRE(links);
    constexpr double kOpen = 1e-9;  // its patch leaves out what lies at the distance t exactly
    NormalField normals(surface.surfelCount());
    PatchWalker walker(surface, *links);
    for (std::size_t i = 0; i < surface.surfelCount(); ++i) {
        const SurfelId s{static_cast<std::uint32_t>(i)};
        Vec3d sum = Vec3d::Zero();
        walker.walk(s, t - kOpen, [&](SurfelId g, const Vec3d&, double d) {
            sum += (1 - 1 / t + d / (t * t)) * surface.trivialNormal(g).cast<double>();
        });
        normals[s] = sum.normalized();
    }
    return normals;
}

struct Answer {
    double before;
    EnergyReport after;
};

Answer solveGoursat(const DigitalSurface& surface, NormalField normals) {
    const Energy energy(surface, std::move(normals), EnergyWeights::uniform(surface, kPaper),
                        kPaper, 1);
    const auto solution =
        minimize(energy, {.displacementLimit = std::nullopt, .tolerance = 1e-9}, {});
    REQUIRE(solution);
    CHECK(solution->converged);
    return {energy.value(energy.restPositions()).total(), energy.value(solution->positions)};
}

}  // namespace

TEST_SUITE("core/solve") {
    TEST_CASE("known answer: Goursat with the upside-down hat of the reference implementation") {
        const auto surface = extractSurface(goursatGrid(), {});
        REQUIRE(surface);
        REQUIRE(surface->surfelCount() == 2454);
        REQUIRE(surface->pointelCount() == 2456);
        const Answer answer = solveGoursat(*surface, invertedHatNormals(*surface, 3));
        CHECK(answer.before == doctest::Approx(1684.34022719).epsilon(1e-9));
        CHECK(answer.after.total() == doctest::Approx(3.42507467).epsilon(1e-8));
        CHECK(answer.after.data == doctest::Approx(0.682457147).epsilon(1e-7));
        CHECK(answer.after.alignment == doctest::Approx(2.064262440).epsilon(1e-7));
        CHECK(answer.after.fairness == doctest::Approx(0.678355086).epsilon(1e-7));
    }

    TEST_CASE("known answer: Goursat with the true hat") {
        const VoxelGrid grid = goursatGrid();
        const auto surface = extractSurface(grid, {});
        REQUIRE(surface);
        auto normals = estimateNormals(grid, *surface, *linkSurfels(*surface, {}),
                                       {.method = NormalMethod::convolved, .radius = 3}, {});
        REQUIRE(normals);
        const Answer answer = solveGoursat(*surface, *std::move(normals));
        CHECK(answer.before == doctest::Approx(1556.9186).epsilon(1e-7));
        CHECK(answer.after.total() == doctest::Approx(2.9414815).epsilon(1e-7));
    }
}
