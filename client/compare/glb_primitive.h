#pragma once

#include "client/compare/glb_document.h"

namespace rivage::client {

/// One primitive of a mesh: triangles before any node moves them.
struct GlbPrimitive {
    std::vector<Eigen::Vector3f> positions;
    std::vector<Eigen::Vector3f> colors;  ///< COLOR_0, linear; empty if there is none
    std::vector<std::array<std::uint32_t, 3>> triangles;
    proto::Json bytes;  ///< by attribute, or of the Draco stream
};

/// How much may still come.
struct GlbRoom {
    std::size_t triangles = 0;
    std::size_t vertices = 0;
};

/// Reads one primitive, Draco or plain.
/// @errors  refused if anything in it contradicts the rest, or is not read here
Outcome<GlbPrimitive> readPrimitive(const GlbDocument& document, const proto::Json& primitive,
                                    const GlbRoom& room);

/// A Draco stream as a primitive.
/// @param triangles  as many as the accessor of the indices says
/// @param vertices   as many as the accessor of POSITION says
/// @param ids        names of attributes to their ids in the stream
Outcome<GlbPrimitive> decodeDraco(std::string_view stream, std::size_t triangles,
                                  std::size_t vertices, const proto::Json& ids);

}  // namespace rivage::client
