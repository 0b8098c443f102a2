#pragma once

#include "core/normals/normal_field.h"
#include "tests/study/mesh.h"

/// Other ways from voxels to a surface, written for comparison only. All of them see labels alone;
/// their crossing points lie half-way between two voxel centres, where surfels have their centres.
namespace rivage::study {

/// Where the surface crosses the segment between the two voxel centres of a surfel.
using Crossings = IdVector<SurfelId, Vec3d>;

/// The middles, moved along their segments by up to `noise` (uniform; at most 0.5 voxel).
[[nodiscard]] Crossings crossings(const DigitalSurface& surface, double noise, std::uint32_t seed);

/// Marching cubes, once for each label against all others. A cell's polygons are traced along its
/// sides, on which two diagonal inner corners are always kept apart, so the surface of a label is
/// closed on any grid; polygons are cut into fans. A triangle belongs to the label and the one that
/// most of its vertices lie next to.
/// @param surface  before pointels were split
/// @source  [LC87]
[[nodiscard]] StudyMesh marchingCubes(const VoxelGrid& grid, const DigitalSurface& surface,
                                      const Crossings& crossings);

/// Dual contouring: a vertex per pointel, where the planes through the crossings of its surfels fit
/// best, relative to their mean; directions with a singular value below 0.1 of the largest are left
/// out.
/// @param clamped  the vertex is put back into the cell of its pointel, coordinate by coordinate
/// @source  [JLSW02]
[[nodiscard]] PointelVectors dualContouring(const DigitalSurface& surface,
                                            const Crossings& crossings, const NormalField& normals,
                                            bool clamped);

/// Surface nets: a vertex per pointel, at the mean of the crossings of its surfels; then each moves
/// `iterations` times half-way to the mean of its neighbours, inside the cell of its pointel. A
/// vertex on a junction linel has only its neighbours along junction linels.
/// @source  [Gib98], [Fri22]
[[nodiscard]] PointelVectors surfaceNets(const DigitalSurface& surface, const Crossings& crossings,
                                         int iterations);

}  // namespace rivage::study
