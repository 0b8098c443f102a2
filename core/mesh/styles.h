#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/options.h"
#include "core/grid/voxel_grid.h"
#include "core/mesh/mesh.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// How a face looks: an output material and a colour.
struct FaceStyle {
    std::uint32_t material = 0;  ///< index into `Styles::materials`
    Rgba16 color{};              ///< linear
};

/// Maps grid materials to output materials and colours, and collects the output materials in the
/// order of their first use. Grid materials that differ in colour only share an output material.
class Styles {
public:
    Styles(const VoxelGrid& grid, Colors colors)
        : grid_(grid), colors_(colors), made_(grid.materials.size()) {}

    /// The style of a face: that of its inner side. Between two labels, where the inner side lets
    /// light through and the outer one does not, that of the outer side: it is what is seen.
    [[nodiscard]] FaceStyle of(const DigitalSurface& surface, SurfelId s);
    [[nodiscard]] std::vector<MeshMaterial> takeMaterials() { return std::move(materials_); }

private:
    using Key = std::tuple<MaterialClass, bool, std::array<double, 9>>;

    [[nodiscard]] FaceStyle make(const Material& source, bool doubleSided);
    [[nodiscard]] std::uint32_t materialIndex(MeshMaterial material);

    const VoxelGrid& grid_;
    Colors colors_;
    std::vector<MeshMaterial> materials_;
    std::map<Key, std::uint32_t> indices_;
    std::map<std::string, int> namesUsed_;
    /// By grid material, against the background and between two labels.
    IdVector<MaterialId, std::array<std::optional<FaceStyle>, 2>> made_;
};

}  // namespace rivage::core
