#pragma once

#include <cstddef>
#include <vector>

#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// A mesh as a Wavefront OBJ file with quads: one object a part, one group a material. Colours
/// follow the position of a vertex as sRGB values from 0 to 1 (`v x y z r g b`); normals are
/// written unless shading is flat. The triangles of a quad are those of its first corner.
/// @param options  reads `voxelSize`, `pivot`, `up`
/// @return  the same bytes everywhere: numbers have the fewest digits that give the float back
/// @errors  emptyGrid if the mesh has no face; outputTooLarge above `run.limits.maxOutputBytes`;
///          internal if a position is not finite; cancelled or timedOut
/// @cost    O(vertices), about 80 bytes a vertex
Result<std::vector<std::byte>> writeObj(const Mesh& mesh, const OutputOptions& options,
                                        const RunContext& run);

}  // namespace rivage::core
