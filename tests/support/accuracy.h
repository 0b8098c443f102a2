#pragma once

#include <cstddef>
#include <cstdint>

#include "tests/support/regularized.h"
#include "tests/support/shapes.h"

/// How far normals and positions are from those of a known shape, and what every result must keep.
namespace rivage::test {

/// Degrees between estimated and true normals, over surfels.
struct NormalErrors {
    double mean = 0;          ///< of all surfels that are at least 1 voxel from an edge
    double percentile95 = 0;  ///< of the same
    double nearEdges = 0;     ///< mean of those 1 to 3 voxels from an edge; 0 without any
};

/// @param leastPart  connected parts (by links) with fewer surfels are left out: specks of noise
NormalErrors normalErrors(const Shape& shape, const Regularized& result, std::size_t leastPart = 1);

/// Voxels between vertices and the true surface, degrees between the normals of faces and its own.
struct PositionErrors {
    double rms = 0;
    double max = 0;
    double bias = 0;        ///< signed mean; negative: the shape shrank
    double normalMean = 0;  ///< weighted by area
    double normalRms = 0;   ///< each face once
};

/// A vertex between several interfaces counts with the farthest of them. Faces are compared at
/// their centroid, with the cross product of their diagonals.
PositionErrors positionErrors(const Shape& shape, const Regularized& result,
                              std::size_t leastPart = 1);

/// Turns every normal about a random tangent axis, by an angle from a normal distribution.
/// @param sigma  deviation of the angle, degrees
NormalField tilted(const NormalField& normals, double sigma, std::uint32_t seed);

/// Sum over the labels of |volume inside its faces - number of its voxels|, over the voxels of all,
/// in percent. Faces are cut into triangles as the mesh does.
double volumeErrorPercent(const VoxelGrid& grid, const Regularized& result);

/// Edges, as pairs of vertices, that lie in an odd number of faces of a label, over all labels.
/// 0 if every label is closed.
std::size_t countOpenEdges(const DigitalSurface& surface);

/// Vertices that no face uses.
std::size_t countOrphans(const DigitalSurface& surface);

/// The largest displacement of a vertex that is a corner of at least `least` of the planes of a
/// box along the grid: 3 its corners, 2 its edges too.
double largestDisplacement(const Regularized& result, const Vec3i& size, int least);

}  // namespace rivage::test
