#include "core/gltf/gltf_material.h"

namespace rivage::core {
namespace {

constexpr double kDefaultIor = 1.5;  // of the extension and of glTF without it

void setExtension(tinygltf::Material& out, std::set<std::string>& extensions,
                  const std::string& name, const std::string& key, double value) {
    out.extensions[name] = tinygltf::Value(tinygltf::Value::Object{{key, tinygltf::Value(value)}});
    extensions.insert(name);
}

}  // namespace

tinygltf::Material toGltf(const MeshMaterial& material, std::set<std::string>& extensions) {
    tinygltf::Material out;
    out.name = material.name;
    out.doubleSided = material.doubleSided;
    out.pbrMetallicRoughness.baseColorFactor = {1, 1, 1, material.alpha};
    out.pbrMetallicRoughness.metallicFactor = material.metallic;
    out.pbrMetallicRoughness.roughnessFactor = material.roughness;
    if (material.alpha < 1) out.alphaMode = "BLEND";
    if (material.transmission > 0)
        setExtension(out, extensions, "KHR_materials_transmission", "transmissionFactor",
                     material.transmission);
    if (material.ior != kDefaultIor)
        setExtension(out, extensions, "KHR_materials_ior", "ior", material.ior);
    const bool emits = material.emission != std::array<double, 3>{};
    if (emits) out.emissiveFactor.assign(material.emission.begin(), material.emission.end());
    if (emits && material.emissiveStrength != 1)
        setExtension(out, extensions, "KHR_materials_emissive_strength", "emissiveStrength",
                     material.emissiveStrength);
    return out;
}

}  // namespace rivage::core
