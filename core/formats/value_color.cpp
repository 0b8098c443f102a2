#include <cmath>
#include <numbers>

#include "core/formats/label_volume.h"
#include "core/grid/oklab.h"

namespace rivage::core {
namespace {

constexpr double kLightness = 0.74;  // of OKLab; every hue of this chroma is close to sRGB
constexpr double kChroma = 0.12;

}  // namespace

Rgba8 valueColor(std::uint32_t value) {
    const double turns = value * (std::numbers::phi - 1);
    const double hue = 2 * std::numbers::pi * (turns - std::floor(turns));
    return srgbOfOklab({kLightness, kChroma * std::cos(hue), kChroma * std::sin(hue)});
}

}  // namespace rivage::core
