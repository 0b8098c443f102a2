// Writes GLB files that cover the writer's options into the folder named on the command line, with
// expected.json beside them, for the checks in tests/gltf and tests/browser.
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/gltf/write_glb.h"
#include "tests/core/mesh/mesh_fixtures.h"

using namespace rivage::test;

namespace {

VoxelGrid materialsGrid() {
    VoxelGrid grid = colored(makeGrid({15, 3, 3}, 5, [](const Vec3i& v) { return 1 + v.x() / 3; }));
    auto& materials = grid.materials.raw();
    materials[2].kind = MaterialClass::metal;
    materials[2].metallic = 1;
    materials[2].roughness = 0.3;
    materials[3].kind = MaterialClass::glass;
    materials[3].transmission = 0.8;
    materials[3].roughness = 0.1;
    materials[3].ior = 1.3;
    materials[4].kind = MaterialClass::emissive;
    materials[4].emission = 0.9;
    materials[4].emissiveStrength = 4;
    materials[5].kind = MaterialClass::cloud;
    materials[5].transmission = 0.5;
    return grid;
}

VoxelGrid checkerboardGrid() {
    return makeGrid({6, 6, 6}, 1, [](const Vec3i& v) { return v.sum() % 2; });
}

class Fixtures {
public:
    explicit Fixtures(std::filesystem::path folder) : folder_(std::move(folder)) {
        std::filesystem::create_directories(folder_);
    }

    void write(const std::string& name, VoxelGrid grid, const OutputOptions& options,
               double amplitude) {
        const Mesh mesh = build(std::move(grid), options, amplitude).mesh;
        const auto bytes = writeGlb(mesh, options, {{"sample", name}}, {}).value();
        std::ofstream file(folder_ / (name + ".glb"), std::ios::binary);
        file.write(reinterpret_cast<const char*>(bytes.data()),
                   static_cast<std::streamsize>(bytes.size()));
        std::vector<std::size_t> vertices;
        std::vector<std::string> colors;
        for (const MeshPart& part : mesh.parts) {
            std::size_t count = 0;
            for (const MeshPrimitive& primitive : part.primitives)
                count += primitive.positions.size();
            vertices.push_back(count);
        }
        expected_[name + ".glb"] = {{"parts", mesh.parts.size()},
                                    {"materials", mesh.materials.size()},
                                    {"triangles", triangleCount(mesh)},
                                    {"vertices", vertices},
                                    {"draco", options.compression == Compression::draco},
                                    {"normals", options.shading != Shading::flat},
                                    {"colors", options.colors != Colors::none}};
    }

    void finish() const { std::ofstream(folder_ / "expected.json") << expected_.dump(2) << "\n"; }

private:
    std::filesystem::path folder_;
    nlohmann::ordered_json expected_;
};

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::cerr << "usage: write_fixtures FOLDER\n";
        return 2;
    }
    Fixtures fixtures(argv[1]);
    const VoxelGrid island = islandGrid(48);
    fixtures.write("island", island, {}, 0.2);
    fixtures.write("island_plain", island, {.compression = Compression::none}, 0.2);
    fixtures.write("island_interfaces", island, {.parts = Parts::interfaces}, 0.2);
    fixtures.write("island_flat_labels", island,
                   {.colors = Colors::label, .shading = Shading::flat, .up = UpAxis::z}, 0.2);
    fixtures.write("island_crease_bare", island,
                   {.colors = Colors::none, .shading = Shading::crease, .pivot = Pivot::world}, 0);
    fixtures.write("materials", materialsGrid(), {}, 0.1);
    fixtures.write("materials_plain", materialsGrid(), {.compression = Compression::none}, 0.1);
    fixtures.write("checkerboard", checkerboardGrid(), {}, 0);
    fixtures.write("foam", colored(randomGrid(5, {8, 8, 8}, 4)), {.parts = Parts::interfaces}, 0.3);
    fixtures.write("voxel", ballGrid(1, 2), {.dracoPositionBits = 8, .dracoSpeed = 10}, 0);
    fixtures.finish();
    return 0;
}
