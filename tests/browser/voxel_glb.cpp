// Writes the raw voxels of a grid as cubes: what a picture shows before regularization.
// usage: voxel_glb (FILE | SAMPLE) OUT.glb
#include <fstream>
#include <iostream>
#include <iterator>

#include "core/formats/read_scene.h"
#include "core/gltf/write_glb.h"
#include "core/grid/scene.h"
#include "core/mesh/build_mesh.h"
#include "core/samples/samples.h"
#include "core/surface/digital_surface.h"

using namespace rivage::core;

namespace {

Result<Scene> sceneNamed(const std::string& name, InputOptions& input) {
    for (const SampleInfo& sample : sampleInfos())
        if (sample.name == name) {
            input.labels = sample.labels;
            return makeSample(name);
        }
    std::ifstream file(name, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    return readScene(std::as_bytes(std::span(text)), input, {});
}

Result<std::vector<std::byte>> cubes(const std::string& name) {
    InputOptions input;
    const auto scene = sceneNamed(name, input);
    if (!scene) return fail(scene.error());
    const auto grid = mergeScene(*scene, input, {});
    if (!grid) return fail(grid.error());
    const auto surface = extractSurface(*grid, {});
    if (!surface) return fail(surface.error());
    IdVector<PointelId, Vec3d> positions;
    for (const Vec3i& pointel : surface->pointels) positions.push_back(pointel.cast<double>());
    const OutputOptions output{.shading = Shading::flat};
    const auto mesh = buildMesh(*grid, *surface, *linkSurfels(*surface, {}), positions, output, {});
    if (!mesh) return fail(mesh.error());
    return writeGlb(*mesh, output, {{"input", name}}, {});
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::cerr << "usage: voxel_glb (FILE | SAMPLE) OUT.glb\n";
        return 2;
    }
    const auto bytes = cubes(argv[1]);
    if (!bytes) {
        std::cerr << argv[1] << ": " << bytes.error().message << "\n";
        return 1;
    }
    std::ofstream file(argv[2], std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes->data()),
               static_cast<std::streamsize>(bytes->size()));
    return file ? 0 : 1;
}
