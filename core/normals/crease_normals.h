#pragma once

#include "core/normals/normal_field.h"

namespace rivage::core {

struct CreaseNormals {
    /// 1 next to a crease, 0 on smooth parts; `normals` hold only where it is above 0.
    IdVector<SurfelId, float> share;
    NormalField normals;
};

/// Estimates normals next to creases from votes of planar discs, and next to creases of curved
/// parts from joint bilateral means that those votes guide.
/// @param bent  largest flatness of the discs of radius 4 around each surfel
/// @errors  cancelled
/// @cost    three patches of radius 5 to 6 for the surfels within 6 voxels of a crease
/// @source  METHOD.md 3.5 (c): creases by flatness; ours: the rest
Result<CreaseNormals> creaseNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                    const IdVector<SurfelId, float>& bent, const RunContext& run);

}  // namespace rivage::core
