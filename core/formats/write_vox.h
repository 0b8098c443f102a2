#pragma once

#include <cstddef>
#include <vector>

#include "core/base/result.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Writes a scene as a MagicaVoxel file, version 200, with its instances as a scene graph, its
/// palette and its materials. Material id i becomes colour index i. The name of a material becomes
/// the name of its palette row of eight entries, the only names that the format has; the first
/// name in a row counts.
/// @errors emptyGrid without a model or an instance; tooLarge if a model is longer than 256;
///         tooManyLabels above 255 materials; outputTooLarge above 4 GiB
/// @cost   O(voxels), 4 bytes each
Result<std::vector<std::byte>> writeVox(const Scene& scene);

}  // namespace rivage::core
