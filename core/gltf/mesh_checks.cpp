#include "core/gltf/mesh_checks.h"

#include <string>

namespace rivage::core {
namespace {

bool allFinite(const MeshPrimitive& primitive, const Placement& placement) {
    for (const Vec3d& position : primitive.positions)
        if (!placement.position(position).allFinite()) return false;
    for (const Vec3f& normal : primitive.normals)
        if (!normal.allFinite()) return false;
    return true;
}

}  // namespace

Result<void> checkMesh(const Mesh& mesh, const Placement& placement) {
    if (triangleCount(mesh) == 0) return fail(ErrorCode::emptyGrid, "the mesh has no face");
    for (const MeshPart& part : mesh.parts)
        for (const MeshPrimitive& primitive : part.primitives)
            if (!allFinite(primitive, placement))
                return fail(ErrorCode::internal, "a position of the mesh is not a finite number");
    return {};
}

Result<void> checkOutputBytes(std::uint64_t bytes, std::uint64_t limit) {
    if (bytes <= limit) return {};
    return fail({.code = ErrorCode::outputTooLarge,
                 .message = "the output takes " + std::to_string(bytes) + " bytes, the limit is " +
                            std::to_string(limit),
                 .limit = limit,
                 .actual = bytes});
}

}  // namespace rivage::core
