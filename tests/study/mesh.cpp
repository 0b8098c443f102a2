#include "tests/study/mesh.h"

namespace rivage::study {

StudyMesh meshOf(const DigitalSurface& surface, const PointelVectors& positions) {
    StudyMesh mesh{positions.raw(), {}};
    mesh.faces.reserve(surface.surfelCount());
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
        const SurfelId s{i};
        const auto& c = surface.corners[s];
        mesh.faces.push_back({{index(c[0]), index(c[1]), index(c[2]), index(c[3])},
                              surface.interfaces[surface.interfaceOf[s]].labels});
    }
    return mesh;
}

std::vector<std::array<Vec3d, 3>> trianglesOf(const StudyMesh& mesh, const Face& face) {
    const auto at = [&](std::uint32_t k) { return mesh.vertices[face.corners[k % 4]]; };
    if (face.isTriangle()) return {{at(0), at(1), at(2)}};
    const std::uint32_t k = (at(2) - at(0)).squaredNorm() <= (at(3) - at(1)).squaredNorm() ? 0 : 1;
    return {{at(k), at(k + 1), at(k + 2)}, {at(k), at(k + 2), at(k + 3)}};
}

}  // namespace rivage::study
