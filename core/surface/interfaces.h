#pragma once

#include "core/surface/digital_surface.h"

namespace rivage::core {

/// Numbers the label pairs of a surface whose materials are filled in and groups its surfels:
/// fills `interfaceOf`, `interfaces` and `byInterface`.
/// @return false if `run` asked to stop
bool groupInterfaces(const VoxelGrid& grid, DigitalSurface& surface, const RunContext& run);

}  // namespace rivage::core
