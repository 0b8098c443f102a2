#include "core/formats/vox_materials.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "core/formats/clean_text.h"

namespace rivage::core {
namespace {

constexpr std::size_t kColors = 255;
constexpr std::size_t kColorsPerRow = 8;   // of the palette as the editor shows it
constexpr double kDefaultRoughness = 0.1;  // the editor's own for metal and glass
constexpr double kDefaultIndexMinusOne = 0.3;

std::optional<double> numberOf(const VoxDict& dict, std::string_view key) {
    const std::string_view text = valueOf(dict, key);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

double fraction(double value) { return std::clamp(value, 0.0, 1.0); }

/// Emission grows exponentially with the power of a light, 0..4.
double strengthOf(double flux) { return std::exp2(std::clamp(flux, 0.0, 4.0) + 1); }

MaterialClass classOf(const VoxDict& dict) {
    const std::string_view type = valueOf(dict, "_type");
    if (type == "_metal") return MaterialClass::metal;
    if (type == "_glass") return MaterialClass::glass;
    if (type == "_emit") return MaterialClass::emissive;
    if (type == "_media" || type == "_cloud") return MaterialClass::cloud;
    if (type != "_blend") return MaterialClass::opaque;
    if (numberOf(dict, "_trans").value_or(0) >= 0.5) return MaterialClass::glass;
    return numberOf(dict, "_metal").value_or(0) > 0 ? MaterialClass::metal : MaterialClass::opaque;
}

void applyProperties(const VoxDict& dict, Material& material) {
    material.kind = classOf(dict);
    if (valueOf(dict, "_type").empty() || valueOf(dict, "_type") == "_diffuse") return;
    const double weight = fraction(numberOf(dict, "_weight").value_or(1));
    material.roughness = fraction(numberOf(dict, "_rough").value_or(kDefaultRoughness));
    const double ior = numberOf(dict, "_ior").value_or(kDefaultIndexMinusOne);
    material.ior = std::clamp(numberOf(dict, "_ri").value_or(1 + ior), 1.0, 3.0);
    switch (material.kind) {
        case MaterialClass::opaque: break;
        case MaterialClass::metal:
            material.metallic = fraction(numberOf(dict, "_metal").value_or(weight));
            break;
        case MaterialClass::glass:
        case MaterialClass::cloud: {
            const double alpha = numberOf(dict, "_alpha").value_or(weight);
            material.transmission = fraction(numberOf(dict, "_trans").value_or(alpha));
            break;
        }
        case MaterialClass::emissive:
            material.emission = fraction(numberOf(dict, "_emit").value_or(weight));
            material.emissiveStrength = strengthOf(numberOf(dict, "_flux").value_or(0));
            break;
    }
}

/// The properties of version 150 are normalized to 0..1.
void applyLegacy(const VoxLegacyMaterial& legacy, Material& material) {
    constexpr std::array kClasses{MaterialClass::opaque, MaterialClass::metal, MaterialClass::glass,
                                  MaterialClass::emissive};
    if (legacy.type == 0 || legacy.type >= kClasses.size()) return;
    const auto value = [&](std::size_t bit, double otherwise) {
        const double stored = legacy.values[bit].value_or(otherwise);
        return std::isfinite(stored) ? fraction(stored) : otherwise;
    };
    const double weight = std::isfinite(legacy.weight) ? fraction(legacy.weight) : 1;
    material.kind = kClasses[legacy.type];
    material.roughness = value(1, kDefaultRoughness);
    material.ior = 1 + value(3, kDefaultIndexMinusOne);
    if (material.kind == MaterialClass::metal) material.metallic = weight;
    if (material.kind == MaterialClass::glass) material.transmission = weight;
    if (material.kind == MaterialClass::emissive) {
        material.emission = weight;
        material.emissiveStrength = strengthOf(4 * value(5, 0));
    }
}

/// Where the artist sees stored colour index `stored`, 1..256.
std::uint32_t displayEntry(const VoxDocument& document, std::size_t stored) {
    if (!document.displayOrder) return static_cast<std::uint32_t>(stored);
    const auto& order = *document.displayOrder;
    const auto found = std::find(order.begin(), order.end(), static_cast<std::uint8_t>(stored));
    return static_cast<std::uint32_t>(found - order.begin()) + 1;
}

/// NOTE names the rows of the palette from the top, and entry 1 is in the lowest row.
std::string rowName(const VoxDocument& document, std::uint32_t entry) {
    const std::size_t row = (entry - 1) / kColorsPerRow;
    const std::size_t names = document.rowNames.size();
    return row < names ? cleanText(document.rowNames[names - 1 - row]) : std::string();
}

}  // namespace

std::array<Rgba8, 256> defaultVoxPalette() {
    constexpr std::uint8_t kRamp[] = {0xee, 0xdd, 0xbb, 0xaa, 0x88, 0x77, 0x55, 0x44, 0x22, 0x11};
    std::array<Rgba8, 256> palette{};
    std::size_t next = 0;
    const auto level = [](int step) { return static_cast<std::uint8_t>(0xff - 0x33 * step); };
    for (int cell = 0; cell < 215; ++cell)
        palette[next++] = {level(cell / 36), level(cell / 6 % 6), level(cell % 6), 0xff};
    for (std::size_t channel = 0; channel < 4; ++channel)
        for (const std::uint8_t value : kRamp) {
            Rgba8 color = {0, 0, 0, 0xff};
            for (std::size_t c = 0; c < 3; ++c)
                if (channel == c || channel == 3) color[c] = value;
            palette[next++] = color;
        }
    return palette;
}

IdVector<MaterialId, Material> voxMaterials(const VoxDocument& document) {
    const std::array<Rgba8, 256> palette = document.palette.value_or(defaultVoxPalette());
    IdVector<MaterialId, Material> materials(kColors + 1);
    for (std::uint32_t i = 1; i <= kColors; ++i) {
        Material& material = materials[MaterialId{static_cast<std::uint16_t>(i)}];
        material.color = palette[i - 1];
        material.source = displayEntry(document, i);
        material.name = rowName(document, material.source);
        if (const auto dict = document.materials.find(i); dict != document.materials.end())
            applyProperties(dict->second, material);
        else if (const auto legacy = document.legacyMaterials.find(i);
                 legacy != document.legacyMaterials.end())
            applyLegacy(legacy->second, material);
    }
    return materials;
}

}  // namespace rivage::core
