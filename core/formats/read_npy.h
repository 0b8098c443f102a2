#pragma once

#include <cstddef>
#include <span>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// Reads a volume of labels from a .npy file, versions 1 to 3, of type b1, u1, u2, u4, u8, i1, i2,
/// i4 or i8 in either byte order. 0 is empty; see `sceneFromVolume` for the materials.
///
/// The array must have three axes. In C order they are [z][y][x], shape (nz, ny, nx); in Fortran
/// order they are [x][y][z], shape (nx, ny, nz): x is the fastest in memory either way, so
/// `numpy.save(f, a)` of a C-ordered `a[z, y, x]` and of a Fortran-ordered `a[x, y, z]` agree.
/// @errors unsupportedFormat if the version, the type or the number of axes is another;
///         malformedInput if the header is, or bytes are missing or left over; tooLarge; those of
///         `sceneFromVolume`
Result<Scene> readNpy(std::span<const std::byte> bytes, const RunContext& run);

}  // namespace rivage::core
