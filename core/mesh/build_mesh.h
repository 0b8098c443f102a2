#pragma once

#include "core/base/ids.h"
#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"
#include "core/mesh/mesh.h"
#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// The output mesh of a digital surface whose pointels have moved: one part per label for
/// `parts=exterior` (its faces against the background), one per interface for `parts=interfaces`.
/// Positions of a pointel are equal in all parts, bit by bit. Normals are those of the whole part,
/// so colour and material borders show no seam; vertices split where colour, material or (with
/// `shading=crease`) normal differ, and where a part touches itself.
/// @param links      of the surface
/// @param positions  of the pointels, grid coordinates, units of the shortest side of a voxel
/// @param output     reads `parts`, `colors` and `shading`
/// @return  parts by label pair, faces in the order of the surfels; the same bits for any thread
///          count
/// @errors  outputTooLarge if a part has 2^30 faces or more; cancelled or timedOut
/// @cost    O(surfels) time, about 150 bytes a surfel
Result<Mesh> buildMesh(const VoxelGrid& grid, const DigitalSurface& surface,
                       const SurfelLinks& links, const IdVector<PointelId, Vec3d>& positions,
                       const OutputOptions& output, const RunContext& run);

}  // namespace rivage::core
