#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "client/failure.h"

namespace rivage::client {

/// What is read at most of one file, so that a small file cannot ask for much memory.
struct SurfaceLimits {
    std::size_t maxTriangles = 8'000'000;
    std::size_t maxVertices = 16'000'000;
    std::size_t maxJsonBytes = 16 << 20;
};

/// The triangles of one node of a GLB, or of one object of an OBJ file.
struct SurfacePart {
    std::string name;
    std::size_t first = 0;  ///< triangle
    std::size_t count = 0;
};

/// A file of a conversion as triangles, all parts in one list, in the coordinates of the file
/// (metres). Positions are finite, indices are in range.
struct Surface {
    std::string format;  ///< "glb", "glb with draco", "obj"
    std::vector<Eigen::Vector3f> positions;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Eigen::Vector3f> colors;  ///< linear, one a position; empty without any colour
    std::vector<SurfacePart> parts;
    std::size_t primitives = 0;
    std::size_t materials = 0;
    proto::Json bytes = proto::Json::object();  ///< what takes how many bytes of the file
    proto::Json report;                         ///< `asset.extras.rivage`; null if there is none
};

/// Reads GLB (glTF 2.0, Draco or plain) or OBJ, told apart by their first bytes.
/// @errors  refused if the file is malformed, uses what is not read here, is beyond the limits, or
///          has no triangle
/// @cost    O(bytes + triangles)
Outcome<Surface> readSurface(const std::string& bytes, const SurfaceLimits& limits = {});

/// The two formats; `readSurface` looks for triangles afterwards.
Outcome<Surface> readGlb(const std::string& bytes, const SurfaceLimits& limits);
Outcome<Surface> readObj(const std::string& bytes, const SurfaceLimits& limits);

/// The failure of a file that breaks its own format, or of one that we do not read.
tl::unexpected<Failure> malformed(std::string detail);
tl::unexpected<Failure> unsupported(std::string detail);

}  // namespace rivage::client
