#pragma once

#include <cstdint>

#include "core/base/ids.h"
#include "core/grid/material.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// The linear value, 0..65535, of an 8-bit sRGB level. Distinct levels stay distinct.
/// @source IEC 61966-2-1; glTF 2.0 wants vertex colours linear
[[nodiscard]] std::uint16_t linearFromSrgb(std::uint8_t level);

/// The 8-bit sRGB level that is nearest to a linear value; undoes `linearFromSrgb` exactly.
[[nodiscard]] std::uint8_t srgbFromLinear(std::uint16_t value);

/// A colour with linear components and full opacity: transparency is the material's.
[[nodiscard]] Rgba16 linearColor(const Rgba8& srgb);

/// A colour that tells a label from its neighbours: hues a golden ratio apart.
[[nodiscard]] Rgba16 labelColor(Label label);

}  // namespace rivage::core
