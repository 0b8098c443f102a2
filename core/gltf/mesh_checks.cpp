#include "core/gltf/mesh_checks.h"

#include <string>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

bool allFinite(const MeshPrimitive& primitive, const Placement& placement, const RunContext& run) {
    bool finite = true;
    serialFor(primitive.positions.size(), run, [&](std::size_t v) {
        finite = finite && placement.position(primitive.positions[v]).allFinite();
    });
    serialFor(primitive.normals.size(), run,
              [&](std::size_t v) { finite = finite && primitive.normals[v].allFinite(); });
    return finite;
}

}  // namespace

Result<void> checkMesh(const Mesh& mesh, const Placement& placement, const RunContext& run) {
    if (triangleCount(mesh) == 0) return fail(ErrorCode::emptyGrid, "the mesh has no face");
    for (const MeshPart& part : mesh.parts)
        for (const MeshPrimitive& primitive : part.primitives)
            if (!allFinite(primitive, placement, run))
                return fail(ErrorCode::internal, "a position of the mesh is not a finite number");
    if (run.stopped()) return fail(run.stopError());
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
