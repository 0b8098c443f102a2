#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "core/pipeline.h"

using namespace rivage::core;

namespace {

ConversionOptions withBrick(EmbossMethod method = EmbossMethod::normals) {
    ConversionOptions options;
    options.method.solve.tolerance = 1e-3;
    options.emboss = {.rules = {{"*", {.kind = TileKind::brick}}}, .detail = 3, .method = method};
    return options;
}

Result<Artifact> converted(const std::string& name, const ConversionOptions& options,
                           const RunContext& run = {}) {
    return convert(*sampleScene(name), options, {}, run);
}

}  // namespace

TEST_SUITE_BEGIN("core/pipeline");

TEST_CASE("convert: relief makes detail^2 quads of each, closed, with what still holds") {
    for (const OutputFormat format : {OutputFormat::glb, OutputFormat::obj})
        for (const EmbossMethod method : {EmbossMethod::normals, EmbossMethod::displace}) {
            ConversionOptions options = withBrick(method);
            options.output.format = format;
            const auto artifact = converted("balls", options);
            REQUIRE(artifact);
            const ConversionReport& report = artifact->report;
            REQUIRE(report.emboss);
            CHECK(report.emboss->surfels == 9 * report.surface.surfels);
            CHECK(report.emboss->tiles[0].surfels == report.surface.surfels);
            CHECK(report.emboss->reliefMax > 0.05);
            CHECK(report.emboss->reliefMax <= 0.2 + 1e-6);
            CHECK(report.emboss->displacementMax < 0.5);
            CHECK(report.emboss->invertedAfter == 0);
            std::uint64_t exterior = 0;
            for (const auto& patch : report.surface.interfaces)
                if (patch.outer == "background") exterior += patch.surfels;
            CHECK(report.output.triangles == 2 * 9 * exterior);
            for (const bool closed : report.output.closed) CHECK(closed);
            const Guarantees guarantees = guaranteesOf(report);
            CHECK(guarantees.separation == Evidence::proved);
            CHECK(guarantees.noIntersection == Evidence::none);
            CHECK(guarantees.noInversion == Evidence::checked);
            CHECK(toJson(report)["emboss"].contains("solver") == (method == EmbossMethod::normals));
        }
}

TEST_CASE("convert: without relief there is no word of it") {
    ConversionOptions options = withBrick();
    options.emboss.rules.clear();
    const auto artifact = converted("voxel", options);
    REQUIRE(artifact);
    CHECK_FALSE(toJson(artifact->report).contains("emboss"));
}

TEST_CASE("determinism: relief has the same bytes for 1, 2 and 7 threads") {
    const auto one = converted("balls", withBrick(), {.threads = 1});
    REQUIRE(one);
    for (const int threads : {2, 7})
        CHECK(converted("balls", withBrick(), {.threads = threads})->bytes == one->bytes);
}

TEST_CASE("stages: relief has one of its own, with its solver's progress") {
    std::vector<Stage> stages;
    double done = 0;
    const RunContext run{.progress = [&](Stage stage, double fraction) {
        if (stages.empty() || stages.back() != stage) stages.push_back(stage);
        if (stage == Stage::emboss) done = fraction;
    }};
    REQUIRE(converted("voxel", withBrick(), run));
    CHECK(stages == std::vector<Stage>{Stage::parse, Stage::surface, Stage::normals, Stage::solve,
                                       Stage::emboss, Stage::mesh, Stage::write});
    CHECK(done == 1);
}

TEST_CASE("reject: a stop at any poll of a relief ends in its error") {
    std::size_t total = 0;
    REQUIRE(converted("voxel", withBrick(), {.stopRequested = [&] { return ++total, false; }}));
    for (std::size_t at = 1; at < total; at += std::max<std::size_t>(1, total / 60)) {
        std::size_t polls = 0;
        const auto artifact =
            converted("voxel", withBrick(), {.stopRequested = [&] { return ++polls >= at; }});
        REQUIRE_FALSE(artifact);
        CHECK(artifact.error().code == ErrorCode::cancelled);
    }
}

TEST_CASE("reject: relief above the memory budget, where the surface alone is below") {
    RunContext run;
    run.limits.maxMemory = 64ULL << 20;
    ConversionOptions options = withBrick();
    options.emboss.detail = 8;
    const auto artifact = converted("house", options, run);
    REQUIRE_FALSE(artifact);
    CHECK(artifact.error().code == ErrorCode::memoryBudget);
    CHECK(artifact.error().actual > std::uint64_t{64} * 8000 * 1000);
    options.emboss.rules.clear();
    CHECK(converted("house", options, run));
}

TEST_SUITE_END();
