#include "core/mesh/styles.h"

#include "core/mesh/colors.h"

namespace rivage::core {
namespace {

bool seeThrough(const Material& material) {
    return material.transmission > 0 &&
           (material.kind == MaterialClass::glass || material.kind == MaterialClass::cloud);
}

MeshMaterial outputMaterial(const Material& source, bool doubleSided) {
    MeshMaterial out{.kind = source.kind,
                     .roughness = source.roughness,
                     .metallic = source.metallic,
                     .ior = source.ior,
                     .doubleSided = doubleSided};
    if (source.kind == MaterialClass::glass) out.transmission = source.transmission;
    if (source.kind == MaterialClass::cloud) out.alpha = 1 - source.transmission;
    if (source.emission > 0) {
        const Rgba16 color = linearColor(source.color);
        for (int i = 0; i < 3; ++i) out.emission[i] = source.emission * color[i] / 65535.0;
        out.emissiveStrength = source.emissiveStrength;
    }
    return out;
}

}  // namespace

FaceStyle Styles::of(const DigitalSurface& surface, SurfelId s) {
    const Material& inner = grid_.materials[surface.innerMaterial[s]];
    const Material& outer = grid_.materials[surface.outerMaterial[s]];
    const bool between = outer.label != Label{0};
    const bool showsOuter =
        colors_ == Colors::voxel && between && seeThrough(inner) && !seeThrough(outer);
    const MaterialId shown = showsOuter ? surface.outerMaterial[s] : surface.innerMaterial[s];
    std::optional<FaceStyle>& made = made_[shown][between ? 1 : 0];
    if (!made) made = make(grid_.materials[shown], between);
    return *made;
}

FaceStyle Styles::make(const Material& source, bool doubleSided) {
    if (colors_ == Colors::voxel)
        return {materialIndex(outputMaterial(source, doubleSided)), linearColor(source.color)};
    const MeshMaterial plain{.doubleSided = doubleSided};
    if (colors_ == Colors::label) return {materialIndex(plain), labelColor(source.label)};
    return {materialIndex(plain), {}};
}

std::uint32_t Styles::materialIndex(MeshMaterial material) {
    const Key key{material.kind,
                  material.doubleSided,
                  {material.roughness, material.metallic, material.transmission, material.alpha,
                   material.ior, material.emission[0], material.emission[1], material.emission[2],
                   material.emissiveStrength}};
    const auto [entry, isNew] =
        indices_.try_emplace(key, static_cast<std::uint32_t>(materials_.size()));
    if (isNew) {
        material.name = className(material.kind);
        const int used = ++namesUsed_[material.name];
        if (used > 1) material.name += " " + std::to_string(used);
        materials_.push_back(std::move(material));
    }
    return entry->second;
}

}  // namespace rivage::core
