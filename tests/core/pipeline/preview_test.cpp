#include <doctest/doctest.h>

#include <map>
#include <utility>

#include "core/pipeline.h"
#include "tests/core/gltf/glb_reader.h"

using namespace rivage::core;
using namespace rivage::test;

namespace {

struct Seen {
    std::vector<Preview> previews;
    std::vector<std::pair<int, double>> energies;  ///< with the step
    Artifact artifact;
};

Seen convertAndSee(const ConversionOptions& options, int threads = 1) {
    Seen seen;
    const auto bytes = sampleScene("torus");
    REQUIRE(bytes);
    const RunContext run{
        .threads = threads,
        .energy = [&](int step, double energy) { seen.energies.emplace_back(step, energy); },
        .preview = [&](Preview preview) { seen.previews.push_back(std::move(preview)); }};
    auto artifact = convert(*bytes, options, {}, run);
    REQUIRE(artifact);
    seen.artifact = *std::move(artifact);
    return seen;
}

ConversionOptions with(SolverKind solver) {
    ConversionOptions options;
    options.method.solve.solver = solver;
    options.method.solve.maxIterations = 100;
    const bool linear = solver == SolverKind::pcg || solver == SolverKind::multigrid ||
                        solver == SolverKind::cholesky;
    if (linear) options.method.solve.displacementLimit = std::nullopt;
    return options;
}

constexpr SolverKind kIterative[] = {SolverKind::projected, SolverKind::accelerated,
                                     SolverKind::pcg, SolverKind::multigrid,
                                     SolverKind::gradientDescent};

}  // namespace

TEST_SUITE("core/pipeline") {
    TEST_CASE("preview: every iterative solver shows steps 0, 1, 4, 16, .. with falling energy") {
        for (const SolverKind solver : kIterative) {
            CAPTURE(static_cast<int>(solver));
            const Seen seen = convertAndSee(with(solver));
            REQUIRE(seen.previews.size() >= 3);
            int step = 0;
            double energy = seen.artifact.report.solve.before.total();
            CHECK(seen.previews[0].energy == energy);
            REQUIRE(seen.energies.size() == seen.previews.size());
            for (std::size_t i = 0; i < seen.previews.size(); ++i)
                CHECK(seen.energies[i] ==
                      std::pair(seen.previews[i].step, seen.previews[i].energy));
            for (const Preview& preview : seen.previews) {
                CHECK(preview.step == step);
                CHECK(preview.energy <= energy);
                energy = preview.energy;
                step = step == 0 ? 1 : 4 * step;
            }
            CHECK(energy < 0.7 * seen.previews[0].energy);
            CHECK(energy >= seen.artifact.report.solve.after.total() * (1 - 1e-9));
        }
    }

    TEST_CASE("preview: cholesky has none but the voxel surface") {
        const Seen seen = convertAndSee(with(SolverKind::cholesky));
        REQUIRE(seen.previews.size() == 1);
        CHECK(seen.previews[0].step == 0);
    }

    TEST_CASE("preview: a GLB of the same form, the first on the lattice") {
        for (const Compression compression : {Compression::draco, Compression::none}) {
            ConversionOptions options = with(SolverKind::projected);
            options.output.compression = compression;
            options.output.voxelSize = 1;
            options.output.pivot = Pivot::corner;
            const Seen seen = convertAndSee(options);
            const auto triangles = readGlb(seen.artifact.bytes).primitive(0, 0).indices.size();
            for (const Preview& preview : seen.previews) {
                CHECK(preview.mediaType == "model/gltf-binary");
                CHECK(readGlb(preview.bytes).primitive(0, 0).indices.size() == triangles);
            }
            for (const auto& place : readGlb(seen.previews[0].bytes).primitive(0, 0).positions)
                for (const float x : place) CHECK(std::abs(x - std::round(x)) < 1e-5F);
            CHECK(seen.previews[1].bytes != seen.previews[0].bytes);
        }
    }

    TEST_CASE("preview: the result and the previews are the same bytes, whoever looks") {
        for (const SolverKind solver : kIterative) {
            CAPTURE(static_cast<int>(solver));
            const Seen one = convertAndSee(with(solver));
            const Seen two = convertAndSee(with(solver), 2);
            const auto unseen = convert(*sampleScene("torus"), with(solver), {}, {});
            REQUIRE(unseen);
            CHECK(one.artifact.bytes == unseen->bytes);
            CHECK(two.artifact.bytes == unseen->bytes);
            REQUIRE(one.previews.size() == two.previews.size());
            for (std::size_t i = 0; i < one.previews.size(); ++i)
                CHECK(one.previews[i].bytes == two.previews[i].bytes);
        }
    }

    TEST_CASE("preview: none for output=obj, but its energy is told") {
        ConversionOptions options = with(SolverKind::projected);
        options.output.format = OutputFormat::obj;
        const Seen seen = convertAndSee(options);
        CHECK(seen.previews.empty());
        CHECK(seen.energies.size() >= 3);
    }
}
