#include <doctest/doctest.h>

#include <Eigen/LU>
#include <cstring>
#include <random>

#include "core/energy/float_operator.h"
#include "core/normals/normal_field.h"
#include "tests/support/balls.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

struct Problem {
    DigitalSurface surface;
    NormalField normals;
    PointelVectors x;

    explicit Problem(const VoxelGrid& grid)
        : surface(*extractSurface(grid, {})), normals(surface.surfelCount()) {
        std::mt19937 random(5);
        std::uniform_real_distribution<double> uniform(-1, 1);
        const auto vector = [&] {
            return Vec3d(uniform(random), uniform(random), uniform(random));
        };
        for (Vec3d& n : normals) n = vector().normalized();
        for (std::size_t i = 0; i < surface.pointelCount(); ++i) x.push_back(vector());
    }
    [[nodiscard]] Energy energy(const EnergyOptions& options, int threads = 1) const {
        return {surface, normals, EnergyWeights::uniform(surface, options), options, threads};
    }
};

FloatVectors applied(const Energy& energy, const PointelVectors& x,
                     FloatOperator::Instructions instructions) {
    FloatVectors in(x.size());
    FloatVectors out(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) in.raw()[i].lanes = lanesOf(x.raw()[i]);
    FloatOperator operation(energy, {}, instructions);
    operation.apply(in, out);
    return out;
}

bool sameBits(const FloatVectors& a, const FloatVectors& b) {
    return std::memcmp(a.raw().data(), b.raw().data(), a.size() * sizeof(Float4)) == 0;
}

const EnergyOptions kForms[] = {{}, presetOptions(Preset::paper).energy};

}  // namespace

TEST_SUITE("core/energy") {
    TEST_CASE("differential: the float operator and its blocks against the double ones") {
        for (const auto& grid : {randomGrid(3, {7, 6, 8}, 3), sectorGrid(20, 8.5)}) {
            const Problem problem(grid);
            for (const EnergyOptions& options : kForms) {
                const Energy energy = problem.energy(options);
                PointelVectors expected;
                Energy::Scratch scratch;
                energy.apply(problem.x, expected, scratch);
                const auto out = applied(energy, problem.x, FloatOperator::Instructions::best);
                const auto blocks = energy.diagonalBlocks();
                const auto found = FloatOperator(energy, {}).diagonalBlocks();
                for (std::size_t i = 0; i < out.size(); ++i) {
                    CHECK((vectorOf(out.raw()[i].lanes) - expected.raw()[i]).norm() < 1e-4);
                    CHECK(out.raw()[i].lanes[3] == 0);
                    const Mat3d& block = blocks.raw()[i];
                    const Symmetric3& mine = found.raw()[i];
                    const Vec3d beside(block(0, 1), block(1, 2), block(2, 0));
                    CHECK((vectorOf(mine.diagonal) - block.diagonal()).norm() < 1e-4);
                    CHECK((vectorOf(mine.beside) - beside).norm() < 1e-4);
                    const Mat3d inverse = block.inverse();
                    const Lanes unit = product(inverseOf(mine), Lanes{1, 2, 3, 0});
                    CHECK((vectorOf(unit) - inverse * Vec3d(1, 2, 3)).norm() <
                          1e-4 * (1 + inverse.norm()));
                }
            }
        }
    }

    TEST_CASE("determinism: the same bits with every instruction set and for threads 1, 2, 7") {
        const Problem problem(ballsGrid(40));
        for (const EnergyOptions& options : kForms) {
            const auto expected =
                applied(problem.energy(options), problem.x, FloatOperator::Instructions::plain);
            for (const int threads : {1, 2, 7})
                CHECK(sameBits(expected, applied(problem.energy(options, threads), problem.x,
                                                 FloatOperator::Instructions::best)));
        }
    }

    TEST_CASE("balls: the surfels that the scene is known to have") {
        CHECK(extractSurface(ballsGrid(64), {})->surfelCount() == 11761);
    }

    TEST_CASE("fairness: on a domain face only neighbours inside the same faces count") {
        // A column of two voxels, its lowest four pointels on the face z = 0.
        DigitalSurface surface =
            *extractSurface(makeGrid({1, 1, 2}, 1, [](const Vec3i&) { return 1; }), {});
        surface.fixedAxes.resize(surface.pointelCount(), 0);
        for (std::uint32_t i = 0; i < surface.pointelCount(); ++i)
            if (surface.pointels[PointelId{i}].z() == 0) surface.fixedAxes[PointelId{i}] = 4;
        const NormalField normals(surface.surfelCount(), Vec3d(0, 0, 1));
        const Energy energy(surface, normals, EnergyWeights::uniform(surface, {}), {}, 1);
        for (std::uint32_t i = 0; i < surface.pointelCount(); ++i) {
            const PointelId p{i};
            const unsigned all = surface.pointels[p].z() == 0   ? 2U
                                 : surface.pointels[p].z() == 1 ? 4U
                                                                : 3U;
            CHECK(static_cast<unsigned>(__builtin_popcount(energy.fairnessSlots(p))) == all);
        }
    }
}
