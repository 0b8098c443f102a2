#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/gltf/placement.h"
#include "core/gltf/quantization.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// A primitive as a Draco stream, with what the glTF accessors must say about it. All figures are
/// those of the decoded stream, which may have more vertices than the primitive.
struct DracoPrimitive {
    std::vector<std::byte> bytes;
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    std::array<float, 3> low{};  ///< output coordinates, metres
    std::array<float, 3> high{};
    /// Unique ids of the attributes in the stream, as the glTF extension names them.
    std::uint32_t positionId = 0;
    std::optional<std::uint32_t> normalId;
    std::optional<std::uint32_t> colorId;
};

/// Encodes one primitive and decodes it once to check it: as many triangles as went in, and the
/// same bounds up to a step of the grid.
/// @param primitive  not empty and finite (`checkMesh`): the library crashes on anything else
/// @param speed      0 smallest .. 10 fastest
/// @errors  internal if the library fails or the check does
/// @cost    O(vertices) time, about 200 bytes a vertex for a while
/// @source  ours: positions are mapped by surface point and other attributes by value, so that
///          colour borders do not cut the connectivity
Result<DracoPrimitive> encodeDraco(const MeshPrimitive& primitive, const Placement& placement,
                                   const Quantization& grid, int speed);

}  // namespace rivage::core
