#include "core/grid/oklab.h"

#include <algorithm>
#include <cmath>

namespace rivage::core {
namespace {

/// The sRGB transfer curve (IEC 61966-2-1), clipped to 8 bits.
std::uint8_t encodeSrgb(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

double decodeSrgb(std::uint8_t level) {
    const double x = level / 255.0;
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

}  // namespace

Vec3d oklabOf(const Rgba8& color) {
    const double r = decodeSrgb(color[0]);
    const double g = decodeSrgb(color[1]);
    const double b = decodeSrgb(color[2]);
    const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

Rgba8 srgbOfOklab(const Vec3d& lab) {
    const auto cube = [](double x) { return x * x * x; };
    const double l = cube(lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2]);
    const double m = cube(lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2]);
    const double s = cube(lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2]);
    return {encodeSrgb(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
            encodeSrgb(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            encodeSrgb(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s), 255};
}

}  // namespace rivage::core
