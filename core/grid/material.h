#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/base/ids.h"

namespace rivage::core {

using Rgba8 = std::array<std::uint8_t, 4>;  ///< sRGB colour, linear alpha

/// The classes that `labels=auto` and the glTF materials tell apart.
enum class MaterialClass : std::uint8_t { opaque, metal, glass, emissive, cloud };

/// The name of a material class in reports and output files.
[[nodiscard]] constexpr const char* className(MaterialClass kind) {
    switch (kind) {
        case MaterialClass::opaque: return "opaque";
        case MaterialClass::metal: return "metal";
        case MaterialClass::glass: return "glass";
        case MaterialClass::emissive: return "emissive";
        case MaterialClass::cloud: return "cloud";
    }
    return "opaque";
}

/// What a material id of a grid stands for. The first entry of a table is always empty space.
struct Material {
    Label label = Label{0};
    std::uint32_t source = 0;  ///< palette entry (.vox, 1..255) or stored value (other formats)
    Rgba8 color = {255, 255, 255, 255};
    MaterialClass kind = MaterialClass::opaque;
    double roughness = 1;         ///< 0..1
    double metallic = 0;          ///< 0..1
    double transmission = 0;      ///< 0..1, glass and cloud
    double ior = 1.5;             ///< index of refraction, at least 1
    double emission = 0;          ///< 0..1, times the colour
    double emissiveStrength = 1;  ///< at least 0, KHR_materials_emissive_strength
    std::string name;             ///< may be empty
};

}  // namespace rivage::core
