#pragma once

#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

using FacePair = std::pair<SurfelId, SurfelId>;  ///< the smaller id first

/// The pairs of faces that share a lattice place but no pointel: with every displacement below
/// half a voxel no other faces without a common pointel can meet.
/// @param surface  after `splitUmbrellas`; before it there are none
/// @return  ascending, each once; some are missing once `run` asked to stop
/// @cost    O(surfels) time; O(split pointels) memory
[[nodiscard]] std::vector<FacePair> touchingFaces(const DigitalSurface& surface,
                                                  const RunContext& run = {});

/// Whether two faces, each cut along the diagonal of `diagonal.h`, run through each other or
/// overlap. Faces that only touch, as all do on the lattice, do not.
/// @source  ours; separating axes of two triangles
[[nodiscard]] bool facesCross(const DigitalSurface& surface,
                              const IdVector<PointelId, Vec3d>& positions, const FacePair& pair);

/// The `touchingFaces` that cross.
[[nodiscard]] std::vector<FacePair> crossingFaces(const DigitalSurface& surface,
                                                  const IdVector<PointelId, Vec3d>& positions,
                                                  const RunContext& run = {});

}  // namespace rivage::core
