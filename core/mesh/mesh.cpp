#include "core/mesh/mesh.h"

namespace rivage::core {

std::size_t vertexCount(const Mesh& mesh) {
    std::size_t count = 0;
    for (const MeshPart& part : mesh.parts)
        for (const MeshPrimitive& primitive : part.primitives) count += primitive.positions.size();
    return count;
}

std::size_t triangleCount(const Mesh& mesh) {
    std::size_t count = 0;
    for (const MeshPart& part : mesh.parts)
        for (const MeshPrimitive& primitive : part.primitives) count += 2 * primitive.quads.size();
    return count;
}

}  // namespace rivage::core
