#include "core/mesh/colors.h"

#include <algorithm>
#include <cmath>

namespace rivage::core {
namespace {

double toLinear(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

double toSrgb(double linear) {
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

std::uint8_t channel(double value) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

}  // namespace

std::uint16_t linearFromSrgb(std::uint8_t level) {
    return static_cast<std::uint16_t>(std::lround(65535 * toLinear(level / 255.0)));
}

std::uint8_t srgbFromLinear(std::uint16_t value) { return channel(toSrgb(value / 65535.0)); }

Rgba16 linearColor(const Rgba8& srgb) {
    return {linearFromSrgb(srgb[0]), linearFromSrgb(srgb[1]), linearFromSrgb(srgb[2]), 65535};
}

Rgba16 labelColor(Label label) {
    constexpr double kGoldenRatio = 0.61803398874989485;
    constexpr double kSaturation = 0.62;
    constexpr double kValue = 0.95;
    const double hue = 6 * std::fmod(kGoldenRatio * index(label), 1.0);
    // The three channels are one trapezoid over the hue circle, a third of a turn apart.
    const auto level = [&](double shift) {
        const double k = std::fmod(shift + hue, 6.0);
        const double dip = std::clamp(std::min(k, 4 - k), 0.0, 1.0);
        return channel(kValue * (1 - kSaturation * dip));
    };
    return linearColor({level(5), level(3), level(1), 255});
}

}  // namespace rivage::core
