#include "core/mesh/build_mesh.h"

#include <doctest/doctest.h>

#include <map>
#include <set>

#include "core/mesh/colors.h"
#include "core/mesh/patch.h"
#include "tests/core/mesh/mesh_fixtures.h"

using namespace rivage::test;

namespace {

using Place = std::array<double, 3>;

Place placeOf(const Vec3d& position) { return {position.x(), position.y(), position.z()}; }

std::set<Place> placesOf(const MeshPart& part) {
    std::set<Place> places;
    for (const MeshPrimitive& primitive : part.primitives)
        for (const Vec3d& position : primitive.positions) places.insert(placeOf(position));
    return places;
}

VoxelGrid voxels(const Vec3i& size, std::initializer_list<Vec3i> filled) {
    return makeGrid(size, 1, [&](const Vec3i& v) {
        return std::count(filled.begin(), filled.end(), v) > 0 ? 1 : 0;
    });
}

void checkEqual(const Mesh& a, const Mesh& b) {
    CHECK(a.materials == b.materials);
    REQUIRE(a.parts.size() == b.parts.size());
    for (std::size_t i = 0; i < a.parts.size(); ++i) {
        REQUIRE(a.parts[i].primitives.size() == b.parts[i].primitives.size());
        CHECK(a.parts[i].name == b.parts[i].name);
        for (std::size_t j = 0; j < a.parts[i].primitives.size(); ++j) {
            const MeshPrimitive& x = a.parts[i].primitives[j];
            const MeshPrimitive& y = b.parts[i].primitives[j];
            CHECK(x.positions == y.positions);
            CHECK(x.normals == y.normals);
            CHECK(x.colors == y.colors);
            CHECK(x.points == y.points);
            CHECK(x.quads == y.quads);
        }
    }
}

}  // namespace

TEST_SUITE_BEGIN("core/mesh");

TEST_CASE("buildMesh: an empty grid has no part") {
    const Built built = build(makeGrid({2, 2, 2}, 1, [](const Vec3i&) { return 0; }));
    CHECK(built.mesh.parts.empty());
    CHECK(vertexCount(built.mesh) == 0);
}

TEST_CASE("buildMesh: one voxel is a cube around its place in the scene") {
    VoxelGrid grid = voxels({1, 1, 1}, {{0, 0, 0}});
    grid.origin = {10, 20, 30};
    const Mesh mesh = build(grid, {.shading = Shading::smooth}).mesh;
    REQUIRE(mesh.parts.size() == 1);
    CHECK(mesh.parts[0].name == "label 1");
    CHECK(mesh.boxMin == Vec3d(10, 20, 30));
    CHECK(mesh.boxMax == Vec3d(11, 21, 31));
    CHECK(vertexCount(mesh) == 8);
    CHECK(triangleCount(mesh) == 12);
    const MeshPrimitive& cube = mesh.parts[0].primitives.at(0);
    const Vec3d centre(10.5, 20.5, 30.5);
    for (std::size_t v = 0; v < 8; ++v) {
        const Vec3d outwards = (cube.positions[v] - centre).normalized();
        CHECK((cube.normals[v].cast<double>() - outwards).norm() < 1e-6);
    }
    for (const Quad& quad : cube.quads) {
        const Vec3d area = (cube.positions[quad[2]] - cube.positions[quad[0]])
                               .cross(cube.positions[quad[3]] - cube.positions[quad[1]]);
        CHECK(area.dot(cube.positions[quad[0]] - centre) > 0);
    }
}

TEST_CASE("buildMesh: crease shading gives a cube three normals a corner, flat shading none") {
    const Mesh creased = build(voxels({1, 1, 1}, {{0, 0, 0}}), {.shading = Shading::crease}).mesh;
    const MeshPrimitive& cube = creased.parts[0].primitives[0];
    CHECK(cube.positions.size() == 24);
    CHECK(std::set<std::uint32_t>(cube.points.begin(), cube.points.end()).size() == 8);
    for (const Vec3f& normal : cube.normals) CHECK(normal.cwiseAbs().maxCoeff() == 1);
    const Mesh flat = build(voxels({1, 1, 1}, {{0, 0, 0}}), {.shading = Shading::flat}).mesh;
    CHECK(flat.parts[0].primitives[0].normals.empty());
    CHECK(vertexCount(flat) == 8);
}

TEST_CASE("buildMesh: exterior has one part a label, interfaces one a label pair") {
    const Built outside = build(islandGrid());
    REQUIRE(outside.mesh.parts.size() == 2);
    CHECK(outside.mesh.parts[0].name == "label 1");
    CHECK(outside.mesh.parts[1].name == "label 2");
    const Built all = build(islandGrid(), {.parts = Parts::interfaces});
    REQUIRE(all.mesh.parts.size() == 3);
    CHECK(all.mesh.parts[1].name == "label 1 | label 2");
    CHECK(all.mesh.parts[1].outer == "label 2");
    CHECK(triangleCount(all.mesh) == 2 * all.surface.surfelCount());
    CHECK(triangleCount(outside.mesh) ==
          triangleCount(all.mesh) - 2 * all.mesh.parts[1].primitives[0].quads.size());
    // Between two solids a face is seen from both sides.
    CHECK(all.mesh.materials[all.mesh.parts[1].primitives[0].material].doubleSided);
    CHECK_FALSE(all.mesh.materials[all.mesh.parts[0].primitives[0].material].doubleSided);
}

TEST_CASE("buildMesh: parts share the positions of their common pointels bit by bit") {
    const Built built = build(islandGrid(), {}, 0.3);
    std::map<Label, std::set<std::uint32_t>> pointels;
    for (std::uint32_t s = 0; s < built.surface.surfelCount(); ++s) {
        const LabelPair& labels =
            built.surface.interfaces[built.surface.interfaceOf[SurfelId{s}]].labels;
        if (labels.outer != Label{0}) continue;
        for (const PointelId p : built.surface.corners[SurfelId{s}])
            pointels[labels.inner].insert(index(p));
    }
    std::set<Place> expected;
    for (const std::uint32_t p : pointels[Label{1}])
        if (pointels[Label{2}].count(p) > 0)
            expected.insert(placeOf(built.positions[PointelId{p}]));
    std::set<Place> shared;
    const std::set<Place> sea = placesOf(built.mesh.parts[0]);
    for (const Place& place : placesOf(built.mesh.parts[1]))
        if (sea.count(place) > 0) shared.insert(place);
    CHECK(shared.size() > 20);
    CHECK(shared == expected);
}

TEST_CASE("buildMesh: every face has exactly the colour of its inner voxel") {
    // Stripes of four materials, all of label 1.
    VoxelGrid grid = colored(makeGrid({9, 5, 4}, 4, [](const Vec3i& v) { return 1 + v.x() % 4; }));
    for (Material& material : grid.materials)
        if (material.source > 0) material.label = Label{1};
    grid.labels.resize(2);
    const Built built = build(grid, {.shading = Shading::smooth}, 0.2);
    REQUIRE(built.mesh.parts.size() == 1);
    const MeshPrimitive& primitive = built.mesh.parts[0].primitives.at(0);
    for (std::uint32_t face = 0; face < primitive.quads.size(); ++face) {
        const MaterialId inner = built.surface.innerMaterial[SurfelId{face}];
        for (const std::uint32_t v : primitive.quads[face])
            CHECK(primitive.colors[v] == linearColor(grid.materials[inner].color));
    }
    // Vertices split at the eight colour borders only, and points stay shared across them.
    const std::size_t points =
        std::set<std::uint32_t>(primitive.points.begin(), primitive.points.end()).size();
    CHECK(points == built.surface.pointelCount());
    CHECK(primitive.positions.size() == points + 8 * (2 * (5 + 4)));
    // No shading seam: vertices on one point have one normal.
    std::map<std::uint32_t, Vec3f> normalOf;
    for (std::size_t v = 0; v < primitive.points.size(); ++v) {
        const auto [entry, isNew] = normalOf.try_emplace(primitive.points[v], primitive.normals[v]);
        CHECK(entry->second == primitive.normals[v]);
    }
}

TEST_CASE("buildMesh: colours by label, or none") {
    const Mesh byLabel = build(islandGrid(), {.colors = Colors::label}).mesh;
    CHECK(byLabel.parts[0].primitives[0].colors[0] == labelColor(Label{1}));
    CHECK(byLabel.parts[1].primitives[0].colors[0] == labelColor(Label{2}));
    CHECK(byLabel.materials.size() == 1);
    const Mesh plain = build(islandGrid(), {.colors = Colors::none}).mesh;
    CHECK(plain.parts[0].primitives[0].colors.empty());
}

TEST_CASE("buildMesh: materials make primitives, and light has one material a colour") {
    VoxelGrid grid = colored(makeGrid({8, 3, 3}, 5, [](const Vec3i& v) {
        return std::min(1 + v.x() / 2 + (v.x() == 7 ? 1 : 0), 5);
    }));
    for (Material& material : grid.materials)
        if (material.source > 0) material.label = Label{1};
    grid.labels.resize(2);
    auto& materials = grid.materials.raw();
    materials[2].kind = MaterialClass::metal;
    materials[2].metallic = 1;
    materials[3].kind = materials[4].kind = MaterialClass::emissive;
    materials[3].emission = materials[4].emission = 0.5;
    materials[3].emissiveStrength = materials[4].emissiveStrength = 4;
    const Mesh mesh = build(grid).mesh;
    REQUIRE(mesh.materials.size() == 4);
    REQUIRE(mesh.parts[0].primitives.size() == 4);
    std::set<std::string> names;
    for (const MeshMaterial& material : mesh.materials) names.insert(material.name);
    CHECK(names == std::set<std::string>{"opaque", "metal", "emissive", "emissive 2"});
    for (const MeshMaterial& material : mesh.materials) {
        if (material.name != "emissive") continue;
        CHECK(material.emissiveStrength == 4);
        CHECK(material.emission[0] == 0.5 * linearFromSrgb(materials[3].color[0]) / 65535.0);
    }
}

TEST_CASE("buildMesh: through clear glass the colour behind it is seen") {
    VoxelGrid grid = islandGrid();
    Material& sea = grid.materials.raw()[1];
    sea.kind = MaterialClass::glass;
    sea.transmission = 0.8;
    const Mesh mesh = build(grid, {.parts = Parts::interfaces}).mesh;
    CHECK(mesh.parts[1].primitives[0].colors[0] == linearColor(grid.materials.raw()[2].color));
    CHECK(mesh.materials[mesh.parts[0].primitives[0].material].transmission == 0.8);
    CHECK(mesh.materials[mesh.parts[1].primitives[0].material].kind == MaterialClass::opaque);
}

TEST_CASE("buildMesh: where cubes touch at a corner or an edge, sheets do not mix") {
    const OutputOptions smooth{.shading = Shading::smooth};
    const Mesh corner = build(voxels({2, 2, 2}, {{0, 0, 0}, {1, 1, 1}}), smooth).mesh;
    CHECK(vertexCount(corner) == 16);
    // At an edge the sheets pair through the background, so the two ends stay one fan each.
    const Mesh edge = build(voxels({2, 2, 1}, {{0, 0, 0}, {1, 1, 0}}), smooth).mesh;
    CHECK(vertexCount(edge) == 14);
}

TEST_CASE("differential: points are the edge-connected fans of a part") {
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        CAPTURE(seed);
        const VoxelGrid grid = randomGrid(seed, {4, 4, 3}, 1 + static_cast<int>(seed % 3));
        const DigitalSurface surface = *extractSurface(grid, {});
        const auto ranks = ranksInInterface(surface);
        const SurfelLinks links = *linkSurfels(surface, {});
        for (std::uint32_t i = 0; i < surface.interfaces.size(); ++i) {
            const Patch patch = buildPatch(surface, InterfaceId{i}, links, ranks, 1);
            const CornerGroups groups = groupFans(patch, {});
            // Slow and obvious: spread group ids over touching corners until nothing changes.
            std::vector<std::size_t> slow(patch.cornerCount());
            for (std::size_t c = 0; c < slow.size(); ++c) slow[c] = c;
            for (bool changed = true; changed;) {
                changed = false;
                for (std::uint32_t edge = 0; edge < patch.cornerCount(); ++edge) {
                    const std::uint32_t other = patch.across[edge];
                    if (other == kNoEdge) continue;
                    CHECK(patch.across[other] == edge);
                    for (const std::uint32_t a : {edge, nextCorner(edge)})
                        for (const std::uint32_t b : {other, nextCorner(other)}) {
                            if (patch.pointelOf(surface, a) != patch.pointelOf(surface, b))
                                continue;
                            const std::size_t low = std::min(slow[a], slow[b]);
                            changed = changed || slow[a] != low || slow[b] != low;
                            slow[a] = slow[b] = low;
                        }
                }
            }
            std::map<std::size_t, std::uint32_t> groupOf;
            for (std::size_t c = 0; c < slow.size(); ++c) {
                const auto [entry, isNew] = groupOf.try_emplace(slow[c], groups.of[c]);
                CHECK(entry->second == groups.of[c]);
            }
            CHECK(groupOf.size() == groups.count);
        }
    }
}

TEST_CASE("property: normals are unit, vertices used, places right on random labels") {
    for (std::uint32_t seed = 1; seed <= 30; ++seed) {
        CAPTURE(seed);
        const auto shading = static_cast<Shading>(seed % 3);
        const Built built = build(colored(randomGrid(seed, {5, 4, 6}, 1 + seed % 4)),
                                  {.parts = Parts::interfaces, .shading = shading}, 1.5);
        std::size_t quads = 0;
        for (const MeshPart& part : built.mesh.parts)
            for (const MeshPrimitive& primitive : part.primitives) {
                quads += primitive.quads.size();
                std::set<std::uint32_t> used;
                for (const Quad& quad : primitive.quads) {
                    used.insert(quad.begin(), quad.end());
                    const auto& at = primitive.positions;
                    CHECK((at[quad[2]] - at[quad[0]]).norm() <= (at[quad[3]] - at[quad[1]]).norm());
                }
                CHECK(used.size() == primitive.positions.size());
                for (const Vec3f& normal : primitive.normals)
                    CHECK(std::abs(normal.norm() - 1) < 1e-5F);
            }
        CHECK(quads == built.surface.surfelCount());
    }
}

TEST_CASE("buildMesh: collapsed faces still get a unit normal") {
    Built built = build(voxels({1, 1, 1}, {{0, 0, 0}}));
    for (Vec3d& position : built.positions) position = Vec3d::Zero();
    const Mesh mesh = *buildMesh(built.grid, built.surface, *linkSurfels(built.surface, {}),
                                 built.positions, {}, {});
    for (const Vec3f& normal : mesh.parts[0].primitives[0].normals)
        CHECK(std::abs(normal.norm() - 1) < 1e-6F);
}

TEST_CASE("determinism: threads 1, 2, 7") {
    const auto meshOf = [](int threads) {
        return build(islandGrid(40), {.shading = Shading::crease}, 0.4, threads).mesh;
    };
    const Mesh one = meshOf(1);
    checkEqual(one, meshOf(2));
    checkEqual(one, meshOf(7));
}

TEST_CASE("buildMesh: a stop request ends it") {
    const Built built = build(islandGrid());
    const auto stopped = buildMesh(built.grid, built.surface, *linkSurfels(built.surface, {}),
                                   built.positions, {}, {.stopRequested = [] { return true; }});
    REQUIRE_FALSE(stopped);
    CHECK(stopped.error().code == ErrorCode::cancelled);
}

TEST_CASE("colors: sRGB levels survive the way to linear and back, black and white are exact") {
    CHECK(linearFromSrgb(0) == 0);
    CHECK(linearFromSrgb(255) == 65535);
    CHECK(linearFromSrgb(188) == 32957);  // 65535 ((188 / 255 + 0.055) / 1.055)^2.4
    for (int level = 0; level < 256; ++level)
        CHECK(srgbFromLinear(linearFromSrgb(static_cast<std::uint8_t>(level))) == level);
    std::set<Rgba16> distinct;
    for (std::uint16_t label = 1; label <= 100; ++label) distinct.insert(labelColor(Label{label}));
    CHECK(distinct.size() == 100);
}

TEST_SUITE_END();
