#pragma once

#include "core/normals/normal_field.h"

namespace rivage::core {

/// Flatness that stands for an incoherent disc: a fold or a thin part.
inline constexpr float kFold = 9;

/// Convolved normals, with what the same windows tell about the surface.
struct SmoothNormals {
    NormalField normals;
    IdVector<SurfelId, float> flatness;  ///< of the disc of radius 4, at most `kFold`
    IdVector<SurfelId, float> density;   ///< of standouts, see noise_level.h
};

/// Averages the trivial normals in discs of a radius; folds and thin parts take the largest smaller
/// disc that is coherent and does not face away from the surfel.
/// @errors  cancelled
/// @cost    one patch a surfel
/// @source  METHOD.md 3.1
Result<SmoothNormals> smoothNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                    double radius, const RunContext& run);

}  // namespace rivage::core
