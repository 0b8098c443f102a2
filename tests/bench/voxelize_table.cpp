#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "core/formats/read_scene.h"
#include "core/formats/write_vox.h"
#include "core/grid/scene.h"
#include "core/pipeline.h"
#include "core/samples/samples.h"
#include "core/voxelize/revoxelize.h"
#include "core/voxelize/voxel_scene.h"
#include "tests/bench/inputs.h"
#include "tests/support/regularized.h"

// voxelize_table [FILE...]: each grid file, or without files each sample scene, regularized once with
// the default options and turned into voxels at several scales on one thread: milliseconds of the
// stages before, of the sampling and of the .vox writer, nanoseconds for a voxel of the result, and
// what became of the input. "lost" are voxels of the input, empty ones too, whose label or material
// the voxel at their centre does not have (odd scales); for even scales the share of solid voxels
// whose material most of the voxels inside have. Every .vox is read again and compared. Exits 1 if
// a voxel is lost or a file is not what was written.

using namespace rivage::core;
using namespace rivage::test;

namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Voxels of the input that the one at their centre is not.
std::size_t countLost(const VoxelGrid& input, const VoxelGrid& fine, int factor) {
    std::size_t lost = 0;
    const Vec3i& size = input.voxels.size();
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x)
                lost += input.voxels.at({x, y, z}) !=
                        fine.voxels.at(factor * Vec3i(x, y, z) + Vec3i::Constant(factor / 2));
    return lost;
}

double majorityShare(const VoxelGrid& input, const VoxelGrid& fine, int factor) {
    std::size_t kept = 0;
    const int cells = factor * factor * factor;
    input.voxels.forEach([&](const Vec3i& voxel, MaterialId material) {
        int same = 0;
        for (int i = 0; i < cells; ++i)
            same += fine.voxels.at(factor * voxel + Vec3i(i % factor, i / factor % factor,
                                                          i / factor / factor)) == material;
        kept += 2 * same >= cells;
    });
    return static_cast<double>(kept) / static_cast<double>(input.voxels.countVoxels());
}

/// Whether a .vox, read again, has the same voxels with the same colours.
bool readsBack(const std::vector<std::byte>& bytes, const VoxelGrid& voxels) {
    RunContext run;
    run.limits.maxInputBytes = bytes.size();
    const auto scene = readScene(bytes, {}, run);
    if (!scene) return false;
    const auto grid = mergeScene(*scene, {}, {});
    if (!grid || grid->voxels.countVoxels() != voxels.voxels.countVoxels()) return false;
    // The file may stand elsewhere; its first voxel in the order of rows tells where.
    const auto lowOf = [](const VoxelGrid& g) {
        Vec3i low = g.voxels.size();
        g.voxels.forEach([&](const Vec3i& v, MaterialId) { low = low.cwiseMin(v); });
        return low;
    };
    const Vec3i shift = lowOf(*grid) - lowOf(voxels);
    bool same = true;
    voxels.voxels.forEach([&](const Vec3i& v, MaterialId m) {
        same =
            same && grid->materials[grid->voxels.at(v + shift)].color == voxels.materials[m].color;
    });
    return same;
}

bool printRow(const std::string& name, const VoxelGrid& grid, const Regularized& model,
              double before, const Scale& scale) {
    VoxelReport report;
    const auto start = Clock::now();
    auto made = revoxelize(grid, model.surface, model.positions, scale, {}, report);
    const double sampling = since(start);
    if (!made) {
        std::printf("| %s | %d/%d | %s |\n", name.c_str(), scale.up, scale.down,
                    made.error().message.c_str());
        return false;
    }
    const auto voxels = made->voxels.countVoxels();
    if (voxels == 0) {
        std::printf("| %s | %d/%d | 0 |\n", name.c_str(), scale.up, scale.down);
        return true;
    }
    const VoxelGrid kept = *made;
    const auto writing = Clock::now();
    const auto scene = voxelScene(*std::move(made), {});
    const auto bytes = writeVox(scene->scene);
    const double written = since(writing);
    std::string fate = "-";
    bool good = bytes && readsBack(*bytes, kept);
    if (scale.down == 1 && scale.up % 2 == 1) {
        const std::size_t lost = countLost(grid, kept, scale.up);
        fate = std::to_string(lost) + " lost";
        good = good && lost == 0;
    } else if (scale.down == 1) {
        char text[32];
        std::snprintf(text, sizeof text, "%.3f %%", 100 * majorityShare(grid, kept, scale.up));
        fate = text;
    } else {
        fate = std::to_string(report.rescued) + " rescued";
    }
    std::printf("| %s | %d/%d | %zu | %zu | %.0f | %.1f | %.1f | %.1f | %zu | %zu | %s | %s |\n",
                name.c_str(), scale.up, scale.down, static_cast<std::size_t>(voxels),
                scene->scene.models.size(), before, sampling, written,
                1e6 * sampling / static_cast<double>(voxels),
                static_cast<std::size_t>(report.folded), bytes ? bytes->size() : 0, fate.c_str(),
                good ? "yes" : "**no**");
    std::fflush(stdout);
    return good;
}

}  // namespace

int main(int argc, char** argv) {
    std::printf(
        "| file | scale | voxels | models | ms before | ms sampling | ms writing | "
        "ns a voxel | folded samples | bytes | input | reads back |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    bool good = true;
    for (const Input& input : inputs(argc - 1, argv + 1)) {
        const auto start = Clock::now();
        const auto scene = readScene(input.bytes, input.options, {});
        const VoxelGrid grid = *mergeScene(*scene, input.options, {});
        const Regularized model = regularize(grid, {});
        const double before = since(start);
        for (const Scale& scale : {Scale{1, 1}, Scale{2, 1}, Scale{3, 1}, Scale{4, 1}, Scale{1, 2}})
            good = printRow(input.name, grid, model, before, scale) && good;
    }
    return good ? 0 : 1;
}
