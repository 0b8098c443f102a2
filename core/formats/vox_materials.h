#pragma once

#include <array>

#include "core/base/ids.h"
#include "core/formats/vox_document.h"
#include "core/grid/material.h"

namespace rivage::core {

/// Colours of a file without a palette; entry i belongs to colour index i + 1, as in an RGBA
/// chunk: a colour cube in steps of 0x33 without black, blue fastest, then ramps of red, green,
/// blue and grey.
/// @source the published format text, section 8
[[nodiscard]] std::array<Rgba8, 256> defaultVoxPalette();

/// The 255 materials of a document by their stored colour index. `source` is the palette entry as
/// the artist sees it: they differ from the stored index only where an IMAP chunk reorders them.
/// @source VOXEL-GLTF.md section 2.4; a property that is no number counts as absent
[[nodiscard]] IdVector<MaterialId, Material> voxMaterials(const VoxDocument& document);

}  // namespace rivage::core
