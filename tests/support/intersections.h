#pragma once

#include <array>
#include <cstddef>

#include "core/energy/energy.h"
#include "core/surface/digital_surface.h"

namespace rivage::test {

using namespace rivage::core;

using Triangle = std::array<Vec3d, 3>;

/// Whether two triangles have more in common than points and segments of their borders, by more
/// than 1e-7. Looks where edges pierce the other triangle; shares nothing with `core/mesh`.
bool trianglesIntersect(const Triangle& s, const Triangle& t);

/// Number of pairs of faces that share no vertex and intersect, each face cut into two triangles as
/// the mesh does. Any displacement will do: faces are looked up by the unit cells that they reach.
std::size_t countIntersections(const DigitalSurface& surface, const PointelVectors& positions);

}  // namespace rivage::test
