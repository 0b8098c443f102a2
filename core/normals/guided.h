#pragma once

#include "core/normals/normal_field.h"

namespace rivage::core {

/// Averages the normals of the discs around each surfel, above all of those that are as flat as
/// the flattest: on smooth parts a second convolution, near a crease the normals of discs that do
/// not cross it.
/// @param radius  of the discs and of the average
/// @errors  cancelled
/// @cost    two patches a surfel
/// @source  METHOD.md 3.5 (a); guided normal filtering, [ZDZ15]
Result<NormalField> guidedNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                  double radius, const RunContext& run);

}  // namespace rivage::core
