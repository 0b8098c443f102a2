#pragma once

#include "core/base/vec.h"
#include "core/grid/material.h"

namespace rivage::core {

/// A colour as OKLab: lightness 0..1 and two opponent axes, in which equal distances look about
/// equally large. The least difference that people see is about 0.02.
/// @source B. Ottosson, "A perceptual color space for image processing" (OKLab), 2020
[[nodiscard]] Vec3d oklabOf(const Rgba8& color);

/// The nearest opaque 8-bit colour, each channel clipped.
[[nodiscard]] Rgba8 srgbOfOklab(const Vec3d& lab);

}  // namespace rivage::core
