#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/energy/energy.h"
#include "core/surface/digital_surface.h"

namespace rivage::study {

using namespace rivage::core;

/// A face of 4 vertices, or of 3 with the last one repeated; counter-clockwise seen from `outer`.
struct Face {
    std::array<std::uint32_t, 4> corners;
    LabelPair labels;
    [[nodiscard]] bool isTriangle() const { return corners[2] == corners[3]; }
};

/// What all methods of the study make.
struct StudyMesh {
    std::vector<Vec3d> vertices;  ///< voxels
    std::vector<Face> faces;
};

/// The surfels of a surface with these vertex positions.
[[nodiscard]] StudyMesh meshOf(const DigitalSurface& surface, const PointelVectors& positions);

/// The triangles of a face, cut along the shorter diagonal.
[[nodiscard]] std::vector<std::array<Vec3d, 3>> trianglesOf(const StudyMesh& mesh,
                                                            const Face& face);

}  // namespace rivage::study
