#pragma once

#include <optional>

#include "core/normals/normal_field.h"

namespace rivage::core {

/// Estimates normals by what each place is: averages over windows that grow with the radius of
/// curvature on smooth parts, votes of planar discs at creases, windows that end at sharp lattice
/// edges, and robust windows on interfaces whose labels are noisy.
///
/// @param radius  of the windows on smooth parts, then fixed; none: at least 5, growing
/// @errors  cancelled
/// @cost    about six patches of radius 5 to 6 a surfel; 250 bytes a surfel
/// @source  METHOD.md 3.5 (c) for the blend; the rest is ours
Result<NormalEstimate> autoNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                   std::optional<double> radius, const RunContext& run);

/// The votes of planar discs alone (`normals=disc-vote`), with windows that end at sharp edges.
/// @errors  cancelled
Result<NormalField> discVoteNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                    double radius, const RunContext& run);

}  // namespace rivage::core
