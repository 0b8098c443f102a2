#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"

namespace rivage::core {

/// Where a volume lies, millimetres: x to the right, y forward, z up.
struct VolumePlace {
    Vec3d spacing = Vec3d::Ones();  ///< sides of a voxel
    Vec3d origin = Vec3d::Zero();   ///< centre of voxel (0, 0, 0)
};

/// Bytes of the values of a volume in an NRRD file before they are packed.
[[nodiscard]] std::uint64_t nrrdVolumeBytes(const Vec3i& size, std::size_t labels);

/// Writes the labels of a grid as an NRRD file with the fields of a segmentation of 3D Slicer:
/// each label is a segment with its name, its number and the colour that most of its voxels have.
/// Values are 8 bit up to 255 labels, else 16 bit, little-endian, x fastest.
/// @param packed  gzip, else raw
/// @errors outputTooLarge above `maxOutputBytes`, of the values before they are packed too;
///         internal; cancelled
/// @cost   O(size.x * size.y * size.z) time, the bytes of the file and one row of memory
/// @source the NRRD format (Teem), the page on segmentations of 3D Slicer's developer guide
Result<std::vector<std::byte>> writeNrrd(const VoxelGrid& grid, const VolumePlace& place,
                                         bool packed, const RunContext& run);

}  // namespace rivage::core
