#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "core/pipeline.h"

using namespace rivage::core;

namespace {

std::vector<std::byte> sample(const std::string& name) {
    auto bytes = sampleScene(name);
    REQUIRE(bytes);
    return *std::move(bytes);
}

/// Few enough solver steps for a test that looks at something else.
ConversionOptions quick() {
    ConversionOptions options;
    options.method.solve.tolerance = 1e-3;
    return options;
}

std::vector<std::byte> rawBox(const Vec3i& size, std::uint8_t value) {
    return std::vector<std::byte>(static_cast<std::size_t>(size.prod()), std::byte{value});
}

ConversionOptions rawOptions(const Vec3i& size) {
    ConversionOptions options = quick();
    options.input.format = GridFormat::raw;
    options.input.dims = size;
    return options;
}

}  // namespace

TEST_SUITE("core/pipeline") {
    TEST_CASE("convert: every sample becomes a closed, untangled GLB") {
        for (const std::string& name : sampleNames()) {
            CAPTURE(name);
            const auto artifact = convert(sample(name), quick(), {}, {});
            REQUIRE(artifact);
            REQUIRE(artifact->bytes.size() > 20);
            CHECK(std::memcmp(artifact->bytes.data(), "glTF", 4) == 0);
            CHECK(artifact->mediaType == "model/gltf-binary");
            const ConversionReport& report = artifact->report;
            CHECK(report.output.bytes == artifact->bytes.size());
            CHECK(report.output.closed.size() == report.input.labels.size());
            for (const bool closed : report.output.closed) CHECK(closed);
            CHECK(report.solve.invertedAfter == 0);
            CHECK(report.solve.after.total() <= report.solve.before.total());
            CHECK(report.solve.displacementMax < 0.5);
        }
    }

    TEST_CASE("convert: the island has two labels and three interfaces") {
        const auto artifact = convert(sample("island"), quick(), {}, {});
        REQUIRE(artifact);
        CHECK(artifact->report.input.labels.size() == 2);
        CHECK(artifact->report.surface.interfaces.size() == 3);
        CHECK(artifact->report.surface.junctionLinels > 100);
        CHECK(artifact->report.output.parts == 2);
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same bytes") {
        for (const OutputFormat format : {OutputFormat::glb, OutputFormat::obj})
            for (const Compression compression : {Compression::draco, Compression::none}) {
                ConversionOptions options = quick();
                options.output.format = format;
                options.output.compression = compression;
                options.output.parts = Parts::interfaces;
                const auto one = convert(sample("foam"), options, {}, {.threads = 1});
                REQUIRE(one);
                for (const int threads : {2, 7}) {
                    const auto other = convert(sample("foam"), options, {}, {.threads = threads});
                    REQUIRE(other);
                    CHECK(other->bytes == one->bytes);
                }
            }
    }

    TEST_CASE("stages: reported in their order, up to the end") {
        std::vector<Stage> stages;
        double last = 0;
        const RunContext run{.progress = [&](Stage stage, double fraction) {
            if (stages.empty() || stages.back() != stage) stages.push_back(stage);
            CHECK(fraction >= 0);
            CHECK(fraction <= 1);
            last = fraction;
        }};
        REQUIRE(convert(sample("voxel"), quick(), {}, run));
        CHECK(stages == std::vector<Stage>{Stage::parse, Stage::surface, Stage::normals,
                                           Stage::solve, Stage::mesh, Stage::write});
        CHECK(last == 1);
    }

    TEST_CASE("stages: the normals tell how far they are, ever further") {
        for (const NormalMethod method : {NormalMethod::automatic, NormalMethod::guided,
                                          NormalMethod::robust, NormalMethod::piecewiseSmooth}) {
            CAPTURE(static_cast<int>(method));
            std::vector<double> fractions;
            const RunContext run{.threads = 2, .progress = [&](Stage stage, double fraction) {
                                     if (stage == Stage::normals) fractions.push_back(fraction);
                                 }};
            auto options = quick();
            options.method.normals.method = method;
            REQUIRE(convert(sample("balls"), options, {}, run));
            CHECK(std::is_sorted(fractions.begin(), fractions.end()));
            CHECK(fractions.size() > 10);
            CHECK(fractions.back() > 0.9);
        }
    }

    TEST_CASE("reject: a stop at any poll ends in its error, never in an artifact") {
        const auto bytes = sample("balls");
        std::size_t total = 0;
        REQUIRE(convert(bytes, quick(), {}, {.stopRequested = [&] { return ++total, false; }}));
        for (std::size_t at = 1; at < total; at += std::max<std::size_t>(1, total / 40)) {
            std::size_t polls = 0;
            const auto artifact = convert(bytes, quick(), {},
                                          {.stopRequested = [&] { return ++polls >= at; },
                                           .stopReason = [] { return ErrorCode::timedOut; }});
            REQUIRE_FALSE(artifact);
            CHECK(artifact.error().code == ErrorCode::timedOut);
        }
    }

    TEST_CASE("reject: predicted memory above the budget, before anything is allocated") {
        RunContext run;
        run.limits.maxMemory = 1 << 20;
        for (const std::string name : {"island", "voxel"}) {
            const auto artifact = convert(sample(name), quick(), {}, run);
            REQUIRE_FALSE(artifact);
            CHECK(artifact.error().code == ErrorCode::memoryBudget);
            CHECK(artifact.error().limit == run.limits.maxMemory);
            CHECK(artifact.error().actual > run.limits.maxMemory);
            CHECK(artifact.error().setting == "--memory-budget");
        }
    }

    TEST_CASE("reject: an empty grid") {
        const Vec3i size(4, 4, 4);
        const auto artifact = convert(rawBox(size, 0), rawOptions(size), {}, {});
        REQUIRE_FALSE(artifact);
        CHECK(artifact.error().code == ErrorCode::emptyGrid);
    }

    TEST_CASE("reject: bytes of no format we read") {
        const std::vector<std::byte> bytes(64, std::byte{'x'});
        const auto artifact = convert(bytes, quick(), {}, {});
        REQUIRE_FALSE(artifact);
        CHECK(artifact.error().code == ErrorCode::unsupportedFormat);
    }

    TEST_CASE("inspect: what the conversion would start from") {
        const auto inspection = inspect(sample("island"), {}, {});
        const auto artifact = convert(sample("island"), quick(), {}, {});
        REQUIRE(inspection);
        REQUIRE(artifact);
        CHECK(inspection->surfels == artifact->report.surface.surfels);
        CHECK(inspection->pointels == artifact->report.surface.pointels);
        CHECK(inspection->input.voxels == artifact->report.input.voxels);
        CHECK(inspection->palette.size() == inspection->input.materials);
        CHECK(inspection->predictedMemory > 500 * inspection->surfels);
    }

    TEST_CASE("samples: an unknown name is refused") {
        const auto bytes = sampleScene("atlantis");
        REQUIRE_FALSE(bytes);
        CHECK(bytes.error().code == ErrorCode::notFound);
    }
}
