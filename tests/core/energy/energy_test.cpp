#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "core/energy/energy.h"
#include "core/normals/normal_field.h"
#include "tests/support/grids.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }

/// A multi-label surface with non-manifold linels, unit normals at random and weights at random:
/// nothing that the operator may rely on.
struct Problem {
    DigitalSurface surface;
    NormalField normals;
    EnergyWeights weights;

    explicit Problem(std::uint32_t seed)
        : surface(*extractSurface(randomGrid(seed, {3, 4, 3}, 3), {})) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> uniform(-1, 1);
        normals.resize(surface.surfelCount());
        for (Vec3d& n : normals)
            n = Vec3d(uniform(random), uniform(random), uniform(random)).normalized();
        weights = EnergyWeights::uniform(surface, {});
        for (double& a : weights.alpha) a = 0.02 + 0.01 * uniform(random);
        for (double& b : weights.beta) b = 1 + 0.5 * uniform(random);
        for (double& g : weights.gamma) g = 0.05 + 0.04 * uniform(random);
    }
    [[nodiscard]] Energy energy(const EnergyOptions& options, int threads = 1) const {
        return {surface, normals, weights, options, threads};
    }
    [[nodiscard]] PointelVectors randomPositions(std::uint32_t seed) const {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> uniform(-0.5, 0.5);
        PointelVectors x(surface.pointelCount());
        for (std::size_t i = 0; i < x.size(); ++i)
            x[pointel(i)] = surface.pointels[pointel(i)].cast<double>() +
                            Vec3d(uniform(random), uniform(random), uniform(random));
        return x;
    }
};

std::vector<EnergyOptions> allForms() {
    std::vector<EnergyOptions> forms;
    for (const Fairness fairness : {Fairness::umbrella, Fairness::tangential})
        for (const JunctionFairness junction :
             {JunctionFairness::umbrella, JunctionFairness::curve})
            forms.push_back({.fairness = fairness, .junctionFairness = junction});
    return forms;
}

Eigen::MatrixXd denseMatrix(const Energy& energy) {
    const auto size = static_cast<Eigen::Index>(3 * energy.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
    energy.forEachSquare([&](std::span<const Energy::Coefficient> row, const Mat3d& block) {
        for (const auto& i : row)
            for (const auto& j : row)
                matrix.block<3, 3>(3 * index(i.pointel), 3 * index(j.pointel)) +=
                    i.value * j.value * block;
    });
    return matrix;
}

}  // namespace

TEST_SUITE("core/energy") {
    TEST_CASE("value: each term of a lone voxel by hand") {
        const DigitalSurface surface =
            *extractSurface(makeGrid({1, 1, 1}, 1, [](const Vec3i&) { return 1; }), {});
        NormalField normals(6);
        for (std::size_t f = 0; f < 6; ++f)
            normals.raw()[f] =
                surface.trivialNormal(SurfelId{static_cast<std::uint32_t>(f)}).cast<double>();
        const EnergyOptions options{.alpha = 0.5,
                                    .beta = 2,
                                    .gamma = 3,
                                    .fairness = Fairness::umbrella,
                                    .junctionFairness = JunctionFairness::umbrella};
        const Energy energy(surface, normals, EnergyWeights::uniform(surface, options), options, 1);
        PointelVectors x = energy.restPositions();
        EnergyReport at = energy.value(x);
        CHECK(at.data == 0);
        CHECK(at.alignment == 0);  // every edge lies in the planes of its two surfels
        // Each of 8 corners is off the mean of its 3 neighbours by (1/3, 1/3, 1/3).
        CHECK(at.fairness == doctest::Approx(3 * 8.0 / 3));
        x[PointelId{7}] += Vec3d(0, 0, 0.5);  // (1, 1, 1) up by a half
        at = energy.value(x);
        CHECK(at.data == doctest::Approx(0.5 * 0.25));
        // Only the top surfel sees it, in two of its edges.
        CHECK(at.alignment == doctest::Approx(2 * 2 * 0.25));
    }

    TEST_CASE("gradient: central differences of each term") {
        const Problem problem(11);
        for (int term = 0; term < 3; ++term) {
            for (EnergyOptions options : allForms()) {
                Problem one = problem;
                if (term != 0)
                    one.weights.alpha = IdVector<PointelId, double>(one.weights.alpha.size(), 0.0);
                if (term != 1)
                    one.weights.beta = IdVector<SurfelId, double>(one.weights.beta.size(), 0.0);
                if (term != 2)
                    one.weights.gamma = IdVector<PointelId, double>(one.weights.gamma.size(), 0.0);
                const Energy energy = one.energy(options);
                PointelVectors x = one.randomPositions(3);
                const PointelVectors gradient = energy.gradient(x);
                constexpr double kStep = 1e-3;  // exact for a quadratic, up to rounding
                for (std::size_t i = 0; i < x.size(); i += 3)
                    for (int k = 0; k < 3; ++k) {
                        const double at = x[pointel(i)][k];
                        x[pointel(i)][k] = at + kStep;
                        const double above = energy.value(x).total();
                        x[pointel(i)][k] = at - kStep;
                        const double below = energy.value(x).total();
                        x[pointel(i)][k] = at;
                        CHECK((above - below) / (2 * kStep) ==
                              doctest::Approx(gradient[pointel(i)][k]).epsilon(1e-7).scale(1));
                    }
            }
        }
    }

    TEST_CASE("operator: equals the assembled matrix, symmetric and positive definite") {
        const Problem problem(12);
        for (const EnergyOptions& options : allForms()) {
            const Energy energy = problem.energy(options);
            const Eigen::MatrixXd matrix = denseMatrix(energy);
            CHECK((matrix - matrix.transpose()).cwiseAbs().maxCoeff() < 1e-14);
            const PointelVectors x = problem.randomPositions(4);
            PointelVectors out;
            Energy::Scratch scratch;
            energy.apply(x, out, scratch);
            Eigen::VectorXd flat(matrix.rows());
            for (std::size_t i = 0; i < x.size(); ++i)
                flat.segment<3>(static_cast<Eigen::Index>(3 * i)) = x[pointel(i)];
            const Eigen::VectorXd expected = matrix * flat;
            const auto blocks = energy.diagonalBlocks();
            for (std::size_t i = 0; i < x.size(); ++i) {
                const auto at = static_cast<Eigen::Index>(3 * i);
                CHECK((out[pointel(i)] - expected.segment<3>(at)).norm() < 1e-12);
                CHECK((blocks[pointel(i)] - matrix.block<3, 3>(at, at)).norm() < 1e-12);
            }
            const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
            CHECK(eigen.eigenvalues()[0] > 0);
        }
    }

    TEST_CASE("operator: a translation costs the data term alone") {
        const Problem problem(13);
        const Energy energy = problem.energy(allForms()[0]);
        PointelVectors out;
        Energy::Scratch scratch;
        const Vec3d t(0.3, -2, 5);
        energy.apply(PointelVectors(energy.size(), t), out, scratch);
        for (std::size_t i = 0; i < out.size(); ++i)
            CHECK((out[pointel(i)] - problem.weights.alpha[pointel(i)] * t).norm() < 1e-12);
    }

    TEST_CASE("majorizer: diag(m) - H is positive semidefinite") {
        for (std::uint32_t seed = 20; seed < 24; ++seed) {
            CAPTURE(seed);
            const Problem problem(seed);
            for (const EnergyOptions& options : allForms()) {
                const Energy energy = problem.energy(options);
                Eigen::MatrixXd matrix = -denseMatrix(energy);
                const auto bound = energy.majorizer();
                for (std::size_t i = 0; i < energy.size(); ++i)
                    for (int k = 0; k < 3; ++k) {
                        const auto at = static_cast<Eigen::Index>(3 * i) + k;
                        matrix(at, at) += bound[pointel(i)];
                    }
                const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
                CHECK(eigen.eigenvalues()[0] > -1e-10);
            }
        }
    }

    TEST_CASE("fairness: nothing of a cube is lost to tangential fairness") {
        const DigitalSurface surface =
            *extractSurface(makeGrid({1, 1, 1}, 1, [](const Vec3i&) { return 1; }), {});
        NormalField normals(6);
        for (std::size_t f = 0; f < 6; ++f)
            normals.raw()[f] =
                surface.trivialNormal(SurfelId{static_cast<std::uint32_t>(f)}).cast<double>();
        const EnergyOptions options{.fairness = Fairness::tangential};
        const Energy energy(surface, normals, EnergyWeights::uniform(surface, options), options, 1);
        CHECK(energy.value(energy.restPositions()).fairness < 1e-3);
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same bits") {
        const VoxelGrid grid = sectorGrid(40, 17);
        const DigitalSurface surface = *extractSurface(grid, {});
        const NormalField normals =
            *estimateNormals(grid, surface, *linkSurfels(surface, {}), {}, {});
        const auto weights = EnergyWeights::uniform(surface, {});
        PointelVectors expected;
        for (const int threads : {1, 2, 7}) {
            const Energy energy(surface, normals, weights, {}, threads);
            const PointelVectors gradient = energy.gradient(energy.restPositions());
            if (threads == 1) expected = gradient;
            CHECK(gradient == expected);
        }
    }
}
