#pragma once

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// A digital surface whose pointels have moved, as the scan conversion sees it: snapped to the
/// fixed-point grid, once, so that faces which share a pointel share its place exactly.
struct MovedSurface {
    const DigitalSurface& surface;
    const IdVector<PointelId, Vec3d>& positions;  ///< units of the shortest side of a voxel
    /// In 1 / `kUnitsPerVoxel` of a voxel along each axis. A position that left the grid by more
    /// than 2^17 voxels is drawn back to there, which tears nothing.
    IdVector<PointelId, Vec3i> snapped;

    /// The middle of a face, voxels.
    [[nodiscard]] Vec3d centre(SurfelId s) const;
    [[nodiscard]] LabelPair labels(SurfelId s) const {
        return surface.interfaces[surface.interfaceOf[s]].labels;
    }
};

/// @param surface, positions  must outlive the result
/// @errors  internal if a position is not finite; cancelled
/// @cost    12 bytes a pointel
Result<MovedSurface> snapSurface(const DigitalSurface& surface,
                                 const IdVector<PointelId, Vec3d>& positions,
                                 const RunContext& run);

}  // namespace rivage::core
