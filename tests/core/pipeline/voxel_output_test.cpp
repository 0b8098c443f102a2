#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/formats/read_scene.h"
#include "core/grid/scene.h"
#include "core/pipeline.h"

using namespace rivage::core;

namespace {

std::vector<std::byte> sample(const std::string& name) {
    auto bytes = sampleScene(name);
    REQUIRE(bytes);
    return *std::move(bytes);
}

/// Few enough solver steps for a test that looks at something else.
ConversionOptions voxels(const Scale& scale, OutputFormat format = OutputFormat::vox) {
    ConversionOptions options;
    options.method.solve.tolerance = 1e-3;
    options.output.format = format;
    options.output.scale = scale;
    return options;
}

VoxelGrid gridOf(std::span<const std::byte> bytes, const InputOptions& options = {}) {
    const auto scene = readScene(bytes, options, {});
    REQUIRE(scene);
    auto grid = mergeScene(*scene, options, {});
    REQUIRE(grid);
    return *std::move(grid);
}

bool sameLook(const Material& a, const Material& b) {
    return a.color == b.color && a.kind == b.kind && a.roughness == b.roughness &&
           a.metallic == b.metallic && a.emission == b.emission && a.source == b.source;
}

const Material& materialAt(const VoxelGrid& grid, const Vec3i& scene) {
    return grid.materials[grid.voxels.at(scene - grid.origin)];
}

/// Voxels of `input` whose material the voxel of `fine` at their centre does not have; `factor` is
/// odd. Empty ones count too.
std::size_t countChanged(const VoxelGrid& input, const VoxelGrid& fine, int factor) {
    std::size_t changed = 0;
    const Vec3i& size = input.voxels.size();
    for (int z = -1; z <= size.z(); ++z)
        for (int y = -1; y <= size.y(); ++y)
            for (int x = -1; x <= size.x(); ++x) {
                const Vec3i at = input.origin + Vec3i(x, y, z);
                const Material& was = materialAt(input, at);
                const Material& is = materialAt(fine, factor * at + Vec3i::Constant(factor / 2));
                const bool empty = was.label == Label{0};
                changed += empty ? is.label != Label{0} : !sameLook(was, is);
            }
    return changed;
}

/// The share of voxels of `input` whose colour most of the voxels inside them have.
double majorityShare(const VoxelGrid& input, const VoxelGrid& fine, int factor) {
    std::size_t kept = 0;
    input.voxels.forEach([&](const Vec3i& voxel, MaterialId material) {
        const Vec3i low = factor * (voxel + input.origin);
        int same = 0;
        for (int i = 0; i < factor * factor * factor; ++i) {
            const Vec3i inside(i % factor, i / factor % factor, i / factor / factor);
            same += materialAt(fine, low + inside).color == input.materials[material].color;
        }
        kept += 2 * same >= factor * factor * factor;
    });
    return static_cast<double>(kept) / static_cast<double>(input.voxels.countVoxels());
}

}  // namespace

TEST_SUITE("core/pipeline") {
    TEST_CASE("voxels: decimating the upsampled model gives every sample back exactly") {
        for (const std::string& name : sampleNames()) {
            CAPTURE(name);
            const auto bytes = sample(name);
            const VoxelGrid input = gridOf(bytes);
            for (const int factor : {1, 3}) {
                CAPTURE(factor);
                const auto artifact = convert(bytes, voxels({factor, 1}), {}, {});
                REQUIRE(artifact);
                CHECK(artifact->extension == "vox");
                const VoxelGrid fine = gridOf(artifact->bytes);
                CHECK(countChanged(input, fine, factor) == 0);
                REQUIRE(artifact->report.voxels);
                CHECK(artifact->report.voxels->voxels == fine.voxels.countVoxels());
                if (factor == 1) CHECK(fine.voxels.countVoxels() == input.voxels.countVoxels());
            }
        }
    }

    TEST_CASE("voxels: twice as fine keeps the majority of nearly every voxel") {
        const auto bytes = sample("island");
        const auto artifact = convert(bytes, voxels({2, 1}), {}, {});
        REQUIRE(artifact);
        CHECK(majorityShare(gridOf(bytes), gridOf(artifact->bytes), 2) > 0.99);
    }

    TEST_CASE("voxels: the palette of a .vox stays, colours are those of the input") {
        const auto bytes = sample("house");
        const VoxelGrid input = gridOf(bytes);
        for (const Scale scale : {Scale{2, 1}, Scale{3, 2}, Scale{1, 2}}) {
            const auto artifact = convert(bytes, voxels(scale), {}, {});
            REQUIRE(artifact);
            const VoxelGrid made = gridOf(artifact->bytes);
            std::map<std::uint32_t, Rgba8> palette;
            for (const Material& material : input.materials)
                palette[material.source] = material.color;
            for (std::size_t m = 1; m < made.materials.size(); ++m)
                CHECK(palette.at(made.materials.raw()[m].source) == made.materials.raw()[m].color);
            CHECK(artifact->report.voxels->colors == made.materials.size() - 1);
            CHECK_FALSE(artifact->report.voxels->paletteError);
        }
    }

    TEST_CASE("voxels: coarser art tells what became of each label") {
        const auto artifact = convert(sample("island"), voxels({1, 2}), {}, {});
        REQUIRE(artifact);
        const VoxelReport& report = *artifact->report.voxels;
        CHECK(report.dims == std::array<int, 3>{32, 34, 20});
        CHECK(report.scale == "1/2");
        CHECK(report.samplesEach == 64);
        REQUIRE(report.topology.size() == 2);
        for (const auto& label : report.topology) {
            CHECK(label.before.components >= 1);
            CHECK(label.after.components >= 1);
        }
        const nlohmann::ordered_json json = toJson(artifact->report);
        CHECK(json["voxels"]["topology"].size() == 2);
        CHECK_FALSE(json["output"].contains("vertices"));
    }

    TEST_CASE("voxels: more than 255 stored values are reduced, and the error is told") {
        ConversionOptions options = voxels({1, 1});
        options.input.format = GridFormat::raw;
        options.input.dims = Vec3i(8, 8, 8);
        options.input.rawType = RawType::u16;
        options.input.labels = LabelMode::solid;
        std::vector<std::byte> bytes;
        for (int i = 1; i <= 512; ++i) {
            bytes.push_back(static_cast<std::byte>(i & 0xff));
            bytes.push_back(static_cast<std::byte>(i >> 8));
        }
        const auto artifact = convert(bytes, options, {}, {});
        REQUIRE(artifact);
        const VoxelReport& report = *artifact->report.voxels;
        CHECK(report.colors <= 255);
        REQUIRE(report.paletteError);
        CHECK(report.paletteError->max > 0);
        CHECK(report.paletteError->max < 0.05);  // one ring of hues: neighbours are close
        CHECK(gridOf(artifact->bytes).materials.size() - 1 == report.colors);
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same voxels") {
        for (const OutputFormat format : {OutputFormat::vox, OutputFormat::nrrd})
            for (const Scale scale : {Scale{2, 1}, Scale{1, 2}}) {
                const auto one = convert(sample("foam"), voxels(scale, format), {}, {.threads = 1});
                REQUIRE(one);
                for (const int threads : {2, 7}) {
                    const auto other =
                        convert(sample("foam"), voxels(scale, format), {}, {.threads = threads});
                    REQUIRE(other);
                    CHECK(other->bytes == one->bytes);
                }
            }
    }

    TEST_CASE("reject: results above a limit, before anything is solved") {
        const auto refused = [](const Scale& scale, OutputFormat format, const Limits& limits) {
            std::set<Stage> stages;
            const auto artifact = convert(
                sample("island"), voxels(scale, format), {},
                {.limits = limits, .progress = [&](Stage stage, double) { stages.insert(stage); }});
            REQUIRE_FALSE(artifact);
            CHECK(artifact.error().field == "/options/scale");
            CHECK(artifact.error().actual > artifact.error().limit);
            CHECK_FALSE(stages.contains(Stage::solve));
            return artifact.error().code;
        };
        CHECK(refused({16, 1}, OutputFormat::vox, {.maxVoxels = 1 << 20}) == ErrorCode::tooLarge);
        CHECK(refused({8, 1}, OutputFormat::vox, {.maxExtent = 500}) == ErrorCode::tooLarge);
        CHECK(refused({8, 1}, OutputFormat::vox, {.maxOutputBytes = 1 << 20}) ==
              ErrorCode::outputTooLarge);
        CHECK(refused({8, 1}, OutputFormat::nrrd, {.maxOutputBytes = 1 << 20}) ==
              ErrorCode::outputTooLarge);
        CHECK(refused({8, 1}, OutputFormat::vox, {.maxMemory = 200 << 20}) ==
              ErrorCode::memoryBudget);
    }

    TEST_CASE("reject: a .vox of voxels that are no cubes; an NRRD file takes them") {
        ConversionOptions options = voxels({2, 1});
        options.input.spacing = Vec3d(1, 1, 2);
        const auto artifact = convert(sample("voxel"), options, {}, {});
        REQUIRE_FALSE(artifact);
        CHECK(artifact.error().code == ErrorCode::invalidOption);
        CHECK(artifact.error().field == "/options/spacing");
        options.output.format = OutputFormat::nrrd;
        options.output.voxelSize = 0.01;
        options.output.pivot = Pivot::corner;
        const auto volume = convert(sample("voxel"), options, {}, {});
        REQUIRE(volume);
        const std::string text(reinterpret_cast<const char*>(volume->bytes.data()), 400);
        CHECK(text.find("space directions: (5,0,0) (0,5,0) (0,0,10)\n") != std::string::npos);
        CHECK(text.find("space origin: (2.5,2.5,5)\n") != std::string::npos);
    }

    TEST_CASE("reject: a stop at any poll ends in its error, never in voxels") {
        for (const Scale scale : {Scale{2, 1}, Scale{1, 2}}) {
            const auto bytes = sample("balls");
            std::size_t total = 0;
            REQUIRE(convert(bytes, voxels(scale), {},
                            {.stopRequested = [&] { return ++total, false; }}));
            for (std::size_t at = 1; at < total; at += std::max<std::size_t>(1, total / 30)) {
                std::size_t polls = 0;
                const auto artifact = convert(bytes, voxels(scale), {},
                                              {.stopRequested = [&] { return ++polls >= at; },
                                               .stopReason = [] { return ErrorCode::timedOut; }});
                REQUIRE_FALSE(artifact);
                CHECK(artifact.error().code == ErrorCode::timedOut);
            }
        }
    }
}
