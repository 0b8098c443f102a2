#pragma once

#include "core/normals/normal_field.h"

namespace rivage::core {

struct PiecewiseSmoothField {
    NormalField normals;
    /// Features: bit k of a surfel is set if v is below 1/2 at both ends of its edge k and a linked
    /// surfel lies across, whose bit is set too.
    IdVector<SurfelId, std::uint8_t> features;
};

/// Smooths a normal field but for a set of features that it finds itself: the minimum (u, v) of
/// the Ambrosio-Tortorelli functional
///
///     alpha |u - g|^2 + v^2 |grad u|^2 + lambda epsilon |grad v|^2 + lambda (1 - v)^2 / 4 epsilon
///
/// with u on surfels and v on the pointels of each interface, alternately for u and v, for epsilon
/// 2, 1, 1/2 and 1/4. v is near 0 along features. Each interface has its own v, and only linked
/// surfels are neighbours, so junctions are discontinuities at no cost.
///
/// @param input  the field g, unit vectors
/// @return  u, normalized, and the features
/// @errors  cancelled
/// @cost    a few thousand passes over the surfels, 200 bytes a surfel
/// @source  [CFGL16]; its discretization u2-v0
Result<PiecewiseSmoothField> piecewiseSmoothNormals(const DigitalSurface& surface,
                                                    const SurfelLinks& links,
                                                    const NormalField& input,
                                                    const PiecewiseSmoothOptions& options,
                                                    const RunContext& run);

}  // namespace rivage::core
