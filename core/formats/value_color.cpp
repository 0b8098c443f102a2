#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/formats/label_volume.h"

namespace rivage::core {
namespace {

constexpr double kLightness = 0.74;  // of OKLab; every hue of this chroma is close to sRGB
constexpr double kChroma = 0.12;

/// The sRGB transfer curve (IEC 61966-2-1), clipped to 8 bits.
std::uint8_t encodeSrgb(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

}  // namespace

/// @source B. Ottosson, "A perceptual color space for image processing" (OKLab), 2020, the
///         matrices from OKLab to linear sRGB
Rgba8 valueColor(std::uint32_t value) {
    const double turns = value * (std::numbers::phi - 1);
    const double hue = 2 * std::numbers::pi * (turns - std::floor(turns));
    const double a = kChroma * std::cos(hue);
    const double b = kChroma * std::sin(hue);
    const auto cube = [](double x) { return x * x * x; };
    const double l = cube(kLightness + 0.3963377774 * a + 0.2158037573 * b);
    const double m = cube(kLightness - 0.1055613458 * a - 0.0638541728 * b);
    const double s = cube(kLightness - 0.0894841775 * a - 1.2914855480 * b);
    return {encodeSrgb(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
            encodeSrgb(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            encodeSrgb(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s), 255};
}

}  // namespace rivage::core
