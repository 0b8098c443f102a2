#pragma once

#include <string>

#include "core/energy/energy.h"

namespace rivage::core {

/// The weights of the options times the factors of the regions. A surfel between a region and the
/// background takes the factors of the region, one between two regions the mean of both; a pointel
/// the mean over its surfels.
/// @param labels  names of the regions; entry 0 is the background
/// @errors  invalidOption if `options.regions` names a region that does not exist
/// @cost    O(surfels) time
/// @source  ours
Result<EnergyWeights> weightsByRegion(const DigitalSurface& surface,
                                      const IdVector<Label, std::string>& labels,
                                      const EnergyOptions& options, const RunContext& run = {});

}  // namespace rivage::core
