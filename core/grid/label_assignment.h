#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/material.h"

namespace rivage::core {

/// Gives every used material its label and names the labels. Labels are numbered from 1 in the
/// order of what made them: material class, palette entry or stored value, or rule of the map;
/// only labels that a used material has exist.
///
/// @param materials  the label of each entry is set; 0 where no rule of a label map takes it
/// @param used       by material id: whether a voxel has it; entry 0 is ignored
/// @param format     decides what `LabelMode::automatic` means: by class for .vox (metal and
///                   emissive count as opaque), one label per stored value otherwise
/// @return           names by label; entry 0 is the background
/// @errors           invalidOption if the map is empty, or names a label or a value twice, or the
///                   value 0, or has two rules that take the rest; tooManyLabels
Result<IdVector<Label, std::string>> assignLabels(IdVector<MaterialId, Material>& materials,
                                                  const std::vector<bool>& used, GridFormat format,
                                                  const InputOptions& options,
                                                  const Limits& limits);

}  // namespace rivage::core
