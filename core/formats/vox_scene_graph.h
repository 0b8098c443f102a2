#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/formats/vox_document.h"
#include "core/grid/scene.h"

namespace rivage::core {

/// The instances of a document in the order of its scene graph, with the poses it was parsed for.
/// A document without a scene graph has one instance, and its models are the frames of it.
///
/// Node 0 is the root. A transform is `parent * own`. An instance is hidden if a node or a layer on
/// its way from the root is.
/// @errors malformedInput on a missing root, node or model, a node id used twice, or a cycle;
///         tooLarge if shared groups unfold to more than `maxModels` instances
/// @cost   O(nodes + instances), no recursion
Result<std::vector<Instance>> expandSceneGraph(const VoxDocument& document, const Limits& limits);

}  // namespace rivage::core
