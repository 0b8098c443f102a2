#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/grid/material.h"

/// The output mesh as plain data: what the writers in `core/gltf` read.
namespace rivage::core {

using Vec3f = Eigen::Vector3f;
using Rgba16 = std::array<std::uint16_t, 4>;  ///< linear, 65535 is 1
using Quad = std::array<std::uint32_t, 4>;    ///< vertices of one primitive

/// A surface material of the output. The colour is not part of it but of the vertices, save for
/// the light it emits, which vertex colours do not multiply.
struct MeshMaterial {
    MaterialClass kind = MaterialClass::opaque;
    double roughness = 1;              ///< 0..1
    double metallic = 0;               ///< 0..1
    double transmission = 0;           ///< 0..1, of glass
    double alpha = 1;                  ///< 0..1, of cloud
    double ior = 1.5;                  ///< at least 1
    std::array<double, 3> emission{};  ///< linear colour of the light, 0..1
    double emissiveStrength = 1;       ///< at least 0
    bool doubleSided = false;          ///< seen from both sides: it lies between two solids
    std::string name = {};             ///< unique in a mesh
    bool operator==(const MeshMaterial&) const = default;
};

/// The faces of one part that have one material. A vertex is used by at least one quad.
struct MeshPrimitive {
    std::uint32_t material = 0;    ///< index into `Mesh::materials`
    std::vector<Vec3d> positions;  ///< scene, z up, in units of the shortest side of a voxel
    std::vector<Vec3f> normals;    ///< unit, or empty: flat shading
    std::vector<Rgba16> colors;    ///< or empty: no colours
    /// The point of the surface that a vertex stands on. Vertices of one part with the same point
    /// have equal positions, they differ in colour, normal or material. Where the part touches
    /// itself, one place in space holds several points.
    std::vector<std::uint32_t> points;
    /// Counter-clockwise seen from outside. The triangles are (0, 1, 2) and (0, 2, 3).
    std::vector<Quad> quads;
};

/// All faces of one interface.
struct MeshPart {
    std::string name;   ///< the label's, or "inner | outer" of an interface between two labels
    std::string inner;  ///< name of the label inside
    std::string outer;  ///< name of the label outside, "background" for none
    std::vector<MeshPrimitive> primitives;  ///< by ascending material
};

struct Mesh {
    std::vector<MeshMaterial> materials;  ///< each is used
    std::vector<MeshPart> parts;          ///< by label pair
    /// The box of the voxels before anything moved, as positions are: what a pivot refers to.
    Vec3d boxMin = Vec3d::Zero();
    Vec3d boxMax = Vec3d::Zero();
};

[[nodiscard]] std::size_t vertexCount(const Mesh& mesh);
[[nodiscard]] std::size_t triangleCount(const Mesh& mesh);

}  // namespace rivage::core
