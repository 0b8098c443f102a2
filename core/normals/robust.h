#pragma once

#include <functional>

#include "core/normals/normal_field.h"

namespace rivage::core {

/// Estimates normals under label noise: convolved normals, then joint bilateral means of the
/// trivial normals guided by the last estimate, in growing windows, the last with a linear fit.
///
/// @param wanted  says of each surfel whether its normal is asked for; the others keep the
///                convolved one
/// @errors  cancelled
/// @cost    four patches a surfel, of radius 4, 6, 6 and 8
/// @source  ours. Mean error under Kanungo noise of 0.1 / 0.2 / 0.3: sphere 1.2 / 1.7 / 2.2 degrees
///          (convolved of radius 5: 1.5 / 2.3 / 2.8), rotated box 2.0 / 3.1 / 4.9 (the better of
///          convolved and Ambrosio-Tortorelli: 5.0 / 6.2 / 8.2)
Result<NormalField> robustNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                  const std::function<bool(SurfelId)>& wanted,
                                  const RunContext& run);

}  // namespace rivage::core
