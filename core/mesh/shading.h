#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/patch.h"

namespace rivage::core {

/// The dihedral angle above which `shading=crease` breaks the shading, degrees.
inline constexpr double kCreaseDegrees = 35;

/// Vector areas of the faces of a patch: normal times area, voxel^2.
[[nodiscard]] std::vector<Vec3d> vectorAreas(const Patch& patch, const DigitalSurface& surface,
                                             const IdVector<PointelId, Vec3d>& positions,
                                             const Workers& workers);

/// One flag an edge: 1 where the faces on both sides differ by at most `kCreaseDegrees`.
[[nodiscard]] std::vector<std::uint8_t> smoothEdges(const Patch& patch,
                                                    const DigitalSurface& surface,
                                                    const std::vector<Vec3d>& areas,
                                                    const Workers& workers);

/// One unit normal a group of corners: the mean of the normals of its faces, weighted by their
/// area and their angle at the corner. Where that mean vanishes (collapsed or opposite faces) the
/// trivial normals take its place.
/// @param areas   of `vectorAreas`
/// @return        finite unit vectors; the same for any thread count
/// @cost          O(corners) time, 24 bytes a corner for a while
/// @source        ours; angle weights make the result independent of the triangulation
[[nodiscard]] std::vector<Vec3f> groupNormals(const Patch& patch, const DigitalSurface& surface,
                                              const IdVector<PointelId, Vec3d>& positions,
                                              const std::vector<Vec3d>& areas,
                                              const CornerGroups& groups, const Workers& workers);

}  // namespace rivage::core
