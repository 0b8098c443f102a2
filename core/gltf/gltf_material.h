#pragma once

#include <set>
#include <string>

#include "core/gltf/private_tinygltf.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// An output material as a glTF material; adds the extensions that it needs to `extensions`.
///
/// Glass is KHR_materials_transmission with alphaMode OPAQUE: renderers then draw it over all
/// opaque surfaces without sorting faces, tint what lies behind by the vertex colour, and keep the
/// reflections; BLEND would fade those too. A reader without the extension shows it opaque.
/// Cloud has no reflections to keep and is alpha with BLEND, which every reader knows.
[[nodiscard]] tinygltf::Material toGltf(const MeshMaterial& material,
                                        std::set<std::string>& extensions);

}  // namespace rivage::core
